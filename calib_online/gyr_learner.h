/// The gyroscope's bias: what is published, and a rival that attitudes may put in its place.
#pragma once
#include "calib_online/gyr_hypothesis.h"
#include "core/calibration.h"

namespace stillpoint::calib {

/// The temperatures that were seen.
struct SeenTemperatures {
  double min_degC = 0.0, max_degC = 0.0;
  std::uint32_t known = 0;
  void see(double temp_degC) noexcept;
};

class GyrLearner {
 public:
  struct State {
    GyrHypothesis::State published, rival;
    Rivalry::State rivalry;
    Attitudes seen;
    Array3 residual{};           ///< of the rates lately, fading
    Stretch attitude;            ///< all readings of the present attitude, whoever believes them
    std::uint32_t replaced = 0;  ///< until what was published before is given up
    std::uint32_t refused = 0;   ///< windows that what is published did not explain
    std::uint32_t in_a_row = 0;  ///< the last of them
  };

  GyrLearner(const GyrFilterParams& params, const TriadCalibration& factory);

  void predict(double dt_s) noexcept;
  /// A window of rest; how well the accelerometer knows where up is, rad. True: what is published changed.
  bool absorb(const Window& w, double direction_sd) noexcept;
  /// A turn was seen: whatever is of its attitude is set aside.
  bool turn_seen() noexcept;
  void publish(double temp_degC, const SeenTemperatures& seen, TriadCalibration& out) noexcept;

  /// What was learnt of another sensor is given up for what is learnt now.
  [[nodiscard]] bool replaced() const noexcept { return replaced_ != 0; }
  [[nodiscard]] std::uint32_t windows() const noexcept { return published_.windows(); }
  [[nodiscard]] State state() const noexcept;
  void restore(const State& s) noexcept;

 private:
  [[nodiscard]] double tau(double temp_degC) const noexcept;
  [[nodiscard]] double vote() const noexcept;
  void end_attitude() noexcept;
  void follow_drift() noexcept;
  [[nodiscard]] bool off_in_many_attitudes() noexcept;
  void open_rival(const Vec3& up_body) noexcept;
  [[nodiscard]] Mat3 doubt(const GyrFilter& present, double tau) const noexcept;

  GyrFilterParams params_;
  TriadCalibration factory_;
  GyrHypothesis published_, rival_;
  Rivalry rivalry_;
  Attitudes seen_;
  Array3 residual_{};
  Stretch attitude_;
  /// What attitudes were off lately, by their information, and the sum of that; 0 after a restart.
  Vec3 off_ = Vec3::Zero();
  Mat3 off_information_ = Mat3::Zero();
  Vec3 drift_radps_ = Vec3::Zero();  ///< of what attitudes are off, the fading mean
  double drift_sq_ = 0.0;            ///< the same of its square
  std::uint32_t replaced_ = 0, refused_ = 0, in_a_row_ = 0;
};

}  // namespace stillpoint::calib

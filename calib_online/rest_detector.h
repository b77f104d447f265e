/// Finds rest windows in the stream of samples: quarter means of the specific force after de-rotation by the gyroscope.
/// Zero-mean vibration averages out, sway and turning are removed by the rotation, what is left is linear acceleration
/// (docs/math/rest.md, R1-R7). Beside the paper's rule (bench/calibration_rest_rules.h) this one also excludes steady
/// turning: gravity and the magnetic field must keep their direction over a baseline that grows to two minutes, and
/// what they cannot exclude (a turn about the vertical without a magnetometer) is handed on as `Window::turn_cov`.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "calib_online/preintegration.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/fields.h"
#include "core/units.h"

namespace stillpoint::calib {

struct RestDetectorParams {
  double window_s = 2.0;
  double acc_spread_mps2 = 0.03;
  double gyr_spread_radps = 0.15 * kRadPerDeg;
  double vibration_mps2 = 0.6;
  double vibration_radps = 3.0 * kRadPerDeg;
  double turn_radps = 0.05 * kRadPerDeg;
  double unseen_turn_sd_radps = 0.1 * kRadPerDeg;
  double gyr_bias_sd_radps = 1.0 * kRadPerDeg;
  double norm_tolerance = 0.15;
  double gravity_mps2 = kStandardGravity_mps2;
  double acc_limit_mps2 = 1e9;  ///< clipped from here on; the daemon sets all three from the full scales of its sensor
  double gyr_limit_radps = 1e9;
  double mag_limit_uT = 1e9;
  double rotation_max_s = 120.0;

  template <class P = RestDetectorParams>
  static constexpr auto fields() {
    return std::tuple{
        field("window_s", &P::window_s, in_range(0.2, 30.0), "length of a rest window"),
        field("acc_spread_mps2", &P::acc_spread_mps2, in_range(1e-4, 2.0),
              "slow change of the specific force's quarter means that is still rest, noise apart"),
        field("gyr_spread_radps", &P::gyr_spread_radps, in_range(1e-5, 1.0), "the same for the angular rate"),
        field("vibration_mps2", &P::vibration_mps2, in_range(1e-3, 50.0), "rms of the specific force inside a window"),
        field("vibration_radps", &P::vibration_radps, in_range(1e-4, 10.0), "rms of the angular rate inside a window"),
        field("turn_radps", &P::turn_radps, in_range(1e-5, 0.1), "steady turning below this is not called a turn"),
        field("unseen_turn_sd_radps", &P::unseen_turn_sd_radps, in_range(1e-6, 0.1),
              "sd of a steady turn that neither gravity nor the field would show"),
        field("gyr_bias_sd_radps", &P::gyr_bias_sd_radps, in_range(1e-5, 1.0),
              "sd of the gyro bias before anything is learnt"),
        field("norm_tolerance", &P::norm_tolerance, in_range(0.005, 1.0),
              "largest deviation of the calibrated norm from gravity, relative"),
        field("gravity_mps2", &P::gravity_mps2, in_range(9.7, 9.9), "local gravity"),
        field("rotation_max_s", &P::rotation_max_s, in_range(1.0, 3600.0),
              "longest way between windows that is integrated"),
    };
  }
};

/// Runs on the sensor thread: fixed storage, no allocation, no lock. Any rate from 10 Hz to 4 kHz, any jitter.
class RestDetector {
 public:
  using Params = RestDetectorParams;
  explicit RestDetector(const Params& params = {});

  /// Takes the next sample in time order. A window comes out at most once in Params::window_s; windows never overlap.
  /// `calibration` serves to de-rotate and to judge; the window's means are raw readings. A window whose `refusal` is
  /// kSwaying or kTurning carries the specific force only: it is good for the accelerometer and says nothing of the
  /// gyro.
  std::optional<Window> push(const RawSample& sample, const CalibrationSnapshot& calibration) noexcept;

  /// True while the last full window was one of rest and no sample since contradicts it: two samples in a row beyond
  /// six sd of the window's own noise, or a tenth of a second's mean beyond what rest may do.
  [[nodiscard]] bool at_rest() const noexcept { return last_refusal_ == Refusal::kNone; }
  /// Why the last evaluated stretch was not one of rest.
  [[nodiscard]] Refusal last_refusal() const noexcept { return last_refusal_; }

 private:
  static constexpr int kQuarters = 4;
  static constexpr int kBlocks = 4;  ///< per quarter: sixteen block means give the covariance of a window's mean

  /// Sums of calibrated readings over one quarter; `ref` is the frame of the rotation chain.
  struct Triad {
    std::array<Vec3, kBlocks> block;      ///< sums
    std::array<Vec3, kBlocks> block_ref;  ///< sums of the de-rotated readings
    std::array<int, kBlocks> n{};
    Vec3 sum_sq = Vec3::Zero();  ///< of the de-rotated readings
    double step_sq = 0.0;  ///< of the differences of successive readings, all axes: white noise without slow parts
    Vec3 raw_step_sq = Vec3::Zero();  ///< the same of the raw readings, an axis
    Vec3 least_step = Vec3::Zero();   ///< smallest raw difference but zero: the lattice
    int steps = 0;
    int clipped = 0;
    Triad() {
      block.fill(Vec3::Zero());
      block_ref.fill(Vec3::Zero());
    }
    [[nodiscard]] int count() const noexcept { return n[0] + n[1] + n[2] + n[3]; }
  };
  /// The way since the middle of the previous window.
  struct Chain {
    Preintegrated rotation;
    double angle_rad = 0.0, duration_s = 0.0;
    bool broken = true;
  };
  struct Quarter {
    std::array<Triad, 3> triad;  ///< acc, gyr, mag
    double temp_sum = 0.0;
    int temp_count = 0, samples = 0;
    std::int64_t t_first_ns = 0, t_last_ns = 0;
    Chain chain;  ///< as it was at the quarter's first sample
  };
  /// What the four quarters say about one triad.
  struct Summary {
    int n = 0;
    Vec3 mean = Vec3::Zero();        ///< over the window, as the readings are
    Vec3 mean_still = Vec3::Zero();  ///< de-rotated to the middle of the window
    Mat3 cov = Mat3::Zero();         ///< of the mean
    Vec3 slope = Vec3::Zero();       ///< of the readings, 1/s
    double white_var = 0.0, power = 0.0;
    double spread_sq = 0.0;        ///< slow change of the quarter means (R3)
    double spread_still_sq = 0.0;  ///< the same, de-rotated
    double spread_turn_sq = 0.0;   ///< the same, with the best steady turn removed
    double spread_noise_sq = 0.0;  ///< what white noise alone gives them: 3 axes x 2 contrasts x var of a quarter mean
    Vec3 noise_sd = Vec3::Zero(), least_step = Vec3::Zero();  ///< of the raw readings, an axis
    int clipped = 0;
    std::array<bool, 3> constant{};  ///< this axis did not change at all
    [[nodiscard]] std::array<bool, 3> noisier_than_lattice() const noexcept;
  };
  struct Evidence {
    std::array<Summary, 3> triad;
    Vec3 turn = Vec3::Zero();              ///< rad/s, from gravity and the field alone
    Mat3 turn_information = Mat3::Zero();  ///< of that; zero about an axis that neither shows
    Mat3 turn_cov = Mat3::Zero();
    bool use_still = false, not_gravity = false;
    std::uint8_t stuck = 0, clipped = 0;
    double temp_degC = 25.0;
  };

  void integrate(const RawSample& sample, const CalibrationSnapshot& calibration, double temp_degC) noexcept;
  void add(const RawSample& sample, const CalibrationSnapshot& calibration, double temp_degC) noexcept;
  void add(std::size_t triad, const Array3& raw, const TriadCalibration& calibration, double temp_degC, int block,
           const Mat3& R_ref_body) noexcept;
  void begin_quarter(const RawSample& sample) noexcept;
  void hold_against_rest(const RawSample& sample, double dt_s) noexcept;
  void restart() noexcept;
  void moved() noexcept;
  std::optional<Window> evaluate(const CalibrationSnapshot& calibration) noexcept;
  [[nodiscard]] Summary summarise(std::size_t triad) const noexcept;
  [[nodiscard]] Mat3 covariance_of_mean(std::size_t triad, const Vec3& mean_in_ref) const noexcept;
  void judge_faults(Evidence& e) const noexcept;
  std::optional<Window> tell_faults(const Evidence& e) noexcept;
  [[nodiscard]] Refusal judge_force(Evidence& e, const CalibrationSnapshot& calibration) const noexcept;
  [[nodiscard]] Refusal judge_rate(Evidence& e, const CalibrationSnapshot& calibration) noexcept;
  [[nodiscard]] bool turns(Evidence& e) noexcept;
  [[nodiscard]] bool rate_beyond_known_bias(const Evidence& e, const CalibrationSnapshot& calibration) const noexcept;
  Window make_window(const Evidence& e, Refusal rate, const CalibrationSnapshot& calibration) noexcept;
  void hand_on_rotation(Window& w, const CalibrationSnapshot& calibration) noexcept;
  [[nodiscard]] Array3 rounding_var(std::size_t triad) const noexcept;
  void keep_anchor(const Evidence& e, Refusal rate) noexcept;

  Params params_;
  std::int64_t quarter_ns_ = 0;
  std::array<Quarter, kQuarters> quarters_{};
  int filled_ = 0;  ///< whole quarters in `quarters_`
  Quarter current_{};
  bool open_ = false;  ///< current_ has a first sample
  Chain chain_{};
  std::int64_t last_t_ns_ = 0;
  bool has_last_ = false, has_last_rate_ = false;
  Vec3 last_rate_ = Vec3::Zero();
  std::array<Vec3, 3> last_raw_{};
  std::array<bool, 3> has_last_raw_{};
  bool moved_ = true;
  /// Directions at the start of the present stretch of rest, renewed every two minutes.
  struct Anchor {
    bool set = false;
    std::array<Vec3, 3> mean{};
    std::array<Mat3, 3> cov{};
    std::array<bool, 3> has{};
    std::int64_t t_ns = 0;
  } anchor_;
  /// The raw readings of the last window of rest, against which every sample since is held.
  struct Held {
    std::array<Vec3, 2> mean{}, drift{};  ///< acc, gyr; drift: mean deviation over the last tenth of a second
    std::array<double, 2> noise_sd{};     ///< of one sample, per axis
    std::array<bool, 2> has{};
    int beyond = 0;  ///< samples in a row
  } held_;
  Vec3 seen_turn_ = Vec3::Zero();  ///< rad/s; the last steady turn that gravity or field showed, zero when it is over
  /// Of each triad's axes, noisier at rest than its lattice: a reading that then does not change is no reading.
  std::array<std::array<bool, 3>, 3> noisy_{};
  std::array<Vec3, 3> lattice_;  ///< the least step of each triad's raw readings ever, moving or not
  std::uint8_t told_stuck_ = 0, told_clipped_ = 0;
  Refusal last_refusal_ = Refusal::kFilling;
};

}  // namespace stillpoint::calib

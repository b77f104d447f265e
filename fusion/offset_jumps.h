/// Has an offset jumped, as it does when a sensor is hit, heated or wakes up? What every innovation since a moment says
/// together, before any one of them says it: (A27) of docs/math/attitude.md.
#pragma once
#include <array>
#include <cstdint>

#include "fusion/error_state.h"

namespace stillpoint::fusion {

/// Two windows of 8 s, one begun in the middle of the other, each with both sensors' hypotheses.
class OffsetJumps {
 public:
  enum class Verdict : std::uint8_t { kNone, kGyroscope, kAccelerometer };

  /// After the measurements of a period, with the world's vertical in body axes. A jump that is likelier than none is
  /// put into `error`; of a body that does not turn, and a gyroscope's of one that a vehicle carries, it looks like an
  /// acceleration and is only stated.
  [[nodiscard]] Verdict observe(ErrorState& error, const Vec3& up_body, bool carried, double period_s) noexcept;

  /// What was said so far is void: the error state itself has been given up, or time runs the other way.
  void restart(ErrorState& error) noexcept;

  /// Variance of the rotation by a jump that may have been and is not believed yet [rad^2, world axes].
  [[nodiscard]] const Array9& doubt_rad2() const noexcept { return doubt_rad2_; }

  /// 1 of a body whose vertical has stood still for a window, 0 of one that has left it by eight degrees.
  [[nodiscard]] double still() const noexcept;

 private:
  struct Candidate {
    int jump = 0;
    Vec3 size = Vec3::Zero();
    Mat3 covariance = Mat3::Zero();
    double surprise = 0.0;  ///< twice the gain in log-likelihood
  };
  [[nodiscard]] static Candidate judge(const ErrorState& error, int jump, double colour) noexcept;
  void begin(ErrorState& error, int window) noexcept;
  void end_windows(ErrorState& error, double period_s) noexcept;

  std::array<double, kJumpWindows> age_s_{};
  Array3 mean_up_{};    ///< of the world, in the body, over a window
  double usual_ = 3.0;  ///< surprise that this motion makes of the gyroscope's hypothesis in a window: of three numbers
  double windows_ = 2.0;  ///< that this is the mean of
  Array9 doubt_rad2_{};
};

}  // namespace stillpoint::fusion

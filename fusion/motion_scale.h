/// How much faster than configured the body travels: a hand's filter that is carried into a car finds out. Derivation
/// and what is measured: (A8a) of docs/math/attitude.md.
#pragma once
#include <array>

namespace stillpoint::fusion {

/// Horizontal motion as the parameters state it - speed s, correlation time t, distance r - with s^2 grown by
/// `scale()`, t by its root (the accelerations stay), r by both.
class MotionScale {
 public:
  /// One period of the covariance: the velocity estimated (east, north) [m/s] and its variance [m^2/s^2].
  void observe(const std::array<double, 2>& velocity_mps, const std::array<double, 2>& variance_m2ps2,
               double usual_speed_mps, double usual_time_s, double period_s) noexcept;

  [[nodiscard]] double speed2() const noexcept { return scale_; }            ///< factor of s^2
  [[nodiscard]] double time() const noexcept;                                ///< factor of t
  [[nodiscard]] double radius2() const noexcept { return scale_ * scale_; }  ///< factor of r^2

 private:
  double scale_ = 1.0;                         ///< >= 1
  std::array<double, 2> mean_velocity_mps_{};  ///< over twice the correlation time
};

}  // namespace stillpoint::fusion

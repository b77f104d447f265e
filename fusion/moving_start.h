/// The vertical of a body that is already under way when its first reading comes: (A32) of docs/math/attitude.md.
#pragma once
#include <type_traits>

#include "core/types.h"

namespace stillpoint::fusion {

/// One reading of a moving accelerometer may point anywhere. In the frame that the gyroscope carries along gravity
/// stays where it is, and the force's mean over T is gravity and the change of the velocity over T.
class MovingStart {
 public:
  /// Mean force [m/s^2] of one period, in axes that do not turn with the body. To be called from the first period on.
  void observe(const Vec3& force_mps2, double period_s) noexcept;
  void end() noexcept { over_ = true; }
  /// A pause: the frame is lost, and a start that was not over begins anew.
  void interrupt() noexcept {
    if (!over_) *this = {};
  }
  void turn_world(const Mat3& R) noexcept;

  /// From when the force is seen to move until its mean can be trusted.
  [[nodiscard]] bool under_way() const noexcept { return moving_ && !over_; }
  /// Mean force so far: up.
  [[nodiscard]] Vec3 force_mps2() const noexcept;
  /// Standard deviation of the tilt of that, per axis.
  [[nodiscard]] double tilt_sd_rad() const noexcept;
  /// Mean square of the velocity that the force has made beside its mean, per axis.
  [[nodiscard]] double speed2_m2ps2() const noexcept;

 private:
  bool moving_ = false, over_ = false;
  double time_s_ = 0.0;
  double force2_ = 0.0;     ///< integral of the squared force
  Array3 velocity_mps_{};   ///< integral of the force: a straight line, and what the body does beside it
  Array3 path_m_{};         ///< integral of that
  Array3 moment_ms_{};      ///< and of that times time
  double velocity2_ = 0.0;  ///< and of its square, m^2/s
};

static_assert(std::is_trivially_copyable_v<MovingStart>);

}  // namespace stillpoint::fusion

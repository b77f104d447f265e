/// Hand or vehicle: how much faster than configured the body travels, where it is the body that does and not the
/// attitude that leans. Derivation and what is measured: (A8a) of docs/math/attitude.md.
#pragma once
#include <array>

#include "core/types.h"

namespace stillpoint::fusion {

/// Horizontal motion as the parameters state it - speed s, correlation time t, distance r - with s^2 grown by a
/// vehicle's scale, t by its root (the accelerations stay), r by both; and s and r by what the body swings to and fro.
class MotionScale {
 public:
  struct Usual {
    double speed_mps, time_s;
  };

  /// What the filter thinks of one period of its covariance, east and north.
  struct Seen {
    std::array<double, 2> velocity_mps, variance_m2ps2;
    std::array<double, 3> force_mps2;  ///< mean of the period, world axes
    double tilt_rad2;                  ///< variance of the tilt, per axis
    double gyr_bias_rad2ps2;           ///< variance of the gyroscope's offset, per axis
    bool turned_unseen = false;        ///< by a gyroscope that was silent: what leans is what that left
  };

  /// A hand would owe the surprise to an attitude that leans, and has leant for as long as the velocity took to grow:
  /// these errors, about and towards east and north, and the share of their squares to be added to what the filter
  /// thinks of its own. None where a rest has shown the gyroscope's offset (A37).
  struct Lean {
    double share = 0.0;
    std::array<double, 2> tilt_rad{}, velocity_mps{};
    bool any_way = false;  ///< an offset that nobody ever knew leans it, any way and at any time
    [[nodiscard]] double rad2() const noexcept {
      return share * (tilt_rad[0] * tilt_rad[0] + tilt_rad[1] * tilt_rad[1]);
    }
  };
  Lean observe(const Seen& seen, const Usual& usual, double period_s) noexcept;

  /// A body at rest is not under way, whatever was thought of it. A vehicle that stops remains one.
  void rest() noexcept;

  /// Time runs the other way from here.
  void turn_back() noexcept;

  /// (A30) Variance of the tilt [rad^2, world axes] that stands for the other answer: a force that has long been
  /// horizontal and is called an acceleration, where the attitude leans. `tilt_rad2` is what else is known of the tilt.
  [[nodiscard]] Mat3 leaning_rad2(double tilt_rad2) const noexcept;

  /// (A38) Variance of the tilt, per axis, of a body that may be carried and has not turned over: a vehicle's
  /// acceleration may last, and be taken for gravity, as far as nobody knows the gyroscope's offset across the
  /// vertical, of this variance.
  [[nodiscard]] double carried_rad2(double level_bias_rad2ps2) const noexcept;

  /// (A37) A rest has shown the gyroscope's offset, and it has not become unknown since.
  [[nodiscard]] bool offset_known() const noexcept { return offset_known_; }

  /// By a vehicle, as far as anybody can tell.
  [[nodiscard]] bool carried() const noexcept;

  [[nodiscard]] double speed2() const noexcept { return scale_ * swing_; }            ///< factor of s^2
  [[nodiscard]] double time() const noexcept;                                         ///< factor of t
  [[nodiscard]] double radius2() const noexcept { return scale_ * scale_ * swing_; }  ///< factor of r^2

 private:
  void weigh(const std::array<double, 3>& force_mps2, double period_s) noexcept;
  void follow_bounce(const Seen& seen, double period_s) noexcept;
  void follow_swing(const Seen& seen, double usual_mps, double period_s) noexcept;
  [[nodiscard]] double vehicle(double lean2, double tilt_rad2) const noexcept;

  double scale_ = 1.0;         ///< >= 1
  double swing_ = 1.0;         ///< >= 1
  double swing_m2ps2_ = 0.0;   ///< mean square of the velocity less its slow part, per axis
  double bounce_m2ps4_ = 0.0;  ///< variance of the force upwards
  double mean_up_mps2_ = 0.0;
  double bounce_s_ = 0.0;
  std::array<double, 2> slow_velocity_mps_{};  ///< over one swing
  std::array<double, 2> mean_velocity_mps_{};  ///< over twice the correlation time
  std::array<double, 3> mean_force_mps2_{};
  std::array<double, 2> lasting_force_mps2_{};  ///< over what no hand keeps up
  double force_s_ = 0.0;
  double log_odds_ = 0.0;      ///< vehicle over leaning tilt
  double excused_s_ = 0.0;     ///< for so long a lean had to excuse the surprise
  bool rested_ = false;        ///< ever
  bool offset_known_ = false;  ///< since then, and excuses nothing
};

}  // namespace stillpoint::fusion

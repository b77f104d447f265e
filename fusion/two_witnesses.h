/// Gravity and the field of the place stand still in the filter's world while its attitude is right. One of them may
/// leave its place without it: the body accelerates, a magnet passes. Both at once is the attitude gone wrong, by a
/// gyroscope or an accelerometer that is no longer the one that the filter knows. (A25) of docs/math/attitude.md.
#pragma once
#include <optional>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::fusion {

/// Plain state, a few operations a period of the covariance. Says nothing without a magnetometer.
class TwoWitnesses {
 public:
  /// Means over a period, world axes of the filter: specific force [m/s^2], field without the body's own [uT].
  void observe(const Vec3& force_mps2, const std::optional<Vec3>& field_uT, double time_s) noexcept;

  /// The field seen so far is no measure of what comes: another iron is taken out, another heading begins.
  void forget_field() noexcept { now_.over_s = place_.over_s = 0.0; }
  /// A pause moves the attitude without any fault.
  void interrupt() noexcept {
    forget_field();
    since_pause_s_ = denied_s_ = 0.0;
  }

  /// Squared lean of gravity [rad^2], while both have left their places; 0: they have not.
  [[nodiscard]] double denied_rad2() const noexcept;

 private:
  struct Mean {
    Array3 value{};
    double over_s = 0.0;
    void add(const Vec3& x, double time_s, double longest_s) noexcept;
  };
  /// How far one of them is from its place, and how far it has been in the last half minute.
  struct Witness {
    double away_rad2 = 0.0, usual_rad2 = 0.02;
    /// Whether it is further away than it has been, and than `least_rad2`; `usual_s` is what it remembers.
    bool leaves(double away_now_rad2, double least_rad2, double time_s, double usual_s) noexcept;
  };
  Mean pull_, now_, place_;
  Witness force_, field_;
  double denied_s_ = 0.0, since_denied_s_ = 1e9, unheard_s_ = 0.0, since_pause_s_ = 0.0;
};

static_assert(std::is_trivially_copyable_v<TwoWitnesses>);

}  // namespace stillpoint::fusion

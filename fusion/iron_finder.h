/// The hard iron of a magnetometer that nobody has calibrated, up to 1 mT, from half a minute of turning: how the
/// reading changes while the body turns. (A18) of docs/math/attitude.md.
#pragma once
#include <type_traits>

#include "fusion/short_turns.h"

namespace stillpoint::fusion {

/// Least squares over short turns: the field of the place cancels in the difference of two readings in world axes,
/// R2 y2 - R1 y1 = (R2 - R1) b, and over a fraction of a second neither an offset of the gyroscope nor the attitude's
/// own error matters. No prior: any size of iron is found. Plain sums with forgetting.
class IronFinder {
 public:
  /// One mean reading: in world axes [uT], with the mean rotation at these readings.
  void observe(const Vec3& seen_world_uT, const Mat3& R_world_body, double time_s) noexcept;

  /// The estimated attitude was corrected by this rotation, which is no turn of the body.
  void turn_world(const Mat3& by) noexcept { short_turns_.turn_world(by); }
  /// What comes next is not connected with what was: a gap.
  void interrupt() noexcept { short_turns_.interrupt(); }
  /// Readings u are K u + c from here on.
  void rebase(const Mat3& K, const Vec3& c) noexcept;

  /// Enough turns for a residual to be measured.
  [[nodiscard]] bool known() const noexcept { return turns_ > fewest_; }
  [[nodiscard]] Vec3 body_uT() const noexcept { return vec(body_); }
  /// Of body_uT(), uT^2: large about an axis that the body has only turned about.
  [[nodiscard]] Mat3 covariance_uT2() const noexcept;

 private:
  void forget() noexcept;
  void add_turn(const Mat3& turn, const Vec3& change_uT) noexcept;
  [[nodiscard]] double degrees_of_freedom() const noexcept;
  [[nodiscard]] double residual_uT2() const noexcept;

  ShortTurns short_turns_;
  Array9 information_{};  ///< sum of w D' D
  Array3 weighted_{};     ///< sum of w D' (change)
  double changes2_ = 0.0, turns_ = 0.0;
  Array3 body_{};
  double fewest_ = 12.0;  ///< turns before it speaks; more of them once turns have denied what it said
  double denied_ = 1.0;   ///< mean square of the last turns' residuals over its expectation
};

static_assert(std::is_trivially_copyable_v<IronFinder>);

}  // namespace stillpoint::fusion

/// Whether the field turns in the body as the gyroscope says that the body turns. Where it does not, one of the two
/// sensors is wrong or a magnet passes: no heading stands on it. (A26) of docs/math/attitude.md.
#pragma once
#include <type_traits>

#include "fusion/short_turns.h"

namespace stillpoint::fusion {

/// Plain sums over the last few short turns.
class TurnWitness {
 public:
  /// One mean reading less the body's own field, in world axes, with the mean rotation at these readings.
  void observe(const Vec3& field_world_uT, const Mat3& R_world_body, double time_s) noexcept;
  void turn_world(const Mat3& by) noexcept { turns_.turn_world(by); }
  void interrupt() noexcept { turns_.interrupt(); }

  /// The turns leave half and more of the field's change unexplained.
  [[nodiscard]] bool denied() const noexcept;

 private:
  ShortTurns turns_;
  double left_uT2_ = 0.0, change_uT2_ = 0.0;  ///< with the gyroscope's turn, and the larger of with and without it
};

static_assert(std::is_trivially_copyable_v<TurnWitness>);

}  // namespace stillpoint::fusion

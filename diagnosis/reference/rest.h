/// Where the body lies still, as the sensors show it and the reference does not deny it.
#pragma once
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// At rest both inertial sensors are as quiet as they ever are, and the gyroscope reads near its own typical offset.
[[nodiscard]] Mask find_rest(const Signals& s);

/// A gyroscope that is wrong at rest (its offset follows the supply, a step) does not wake the body: rests are added
/// where the accelerometer is quiet and the reference, of orientation and position, moves less than 3 mrad/s and 3 mm/s
/// over 2 s (a third of that where it is exact). Nothing is added without a position.
void rest_where_reference_is_still(Mask& rest, const Signals& s, const Series3& rate_radps, const Series3& velocity_mps,
                                   bool exact);

/// Quiet is not still: a boat at anchor is quiet. A rest through which the reference moves steadily is none.
/// `velocity` is empty without a position; `exact`: the reference is arithmetic, without a camera's noise.
void wake_where_reference_moves(Mask& rest, const Series3& rate_radps, const Series3& velocity_mps, double dt_s,
                                bool exact);

/// Who sits down still sways. A rest in which the gyroscope sees most of what the reference sees, or the reference most
/// of what the gyroscope sees, is none: that is no noise of either.
void wake_where_both_move(Mask& rest, const Signals& s, const Series3& rate_radps);

/// A body that stops for a moment, but for a slow turn, is as quiet as at rest. Reference and gyroscope turn by the
/// same there, against nothing or what the gyroscope reads in most rests; `noise_rad`: of the reference's attitudes.
void wake_where_both_turn(Mask& rest, const Signals& s, const Series3& rate_radps, double noise_rad);

}  // namespace stillpoint::diag

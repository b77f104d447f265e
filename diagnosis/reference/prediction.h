/// What the reference says that the sensors should have read, and how well it can be known.
#pragma once
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// Sets predicted, world_axis, position, rows and what is known of the reference's own noise; wakes rests through which
/// it moves; mutes what cannot be compared: rows in which the reference was lost, and motion too fast for it.
/// Pre: the readings and the rest are there, the recording has quaternions. Returns the rows in which it was lost.
[[nodiscard]] Mask predict(Signals& s, const io::Recording& recording, Eigen::Index rows_a_frame);

/// Mutes what stands so many rows or fewer beside a lost one; nothing where the sensor has no rows.
void mute_beside(const Mask& lost, Eigen::Index reach, Mask& muted);

}  // namespace stillpoint::diag

/// What the reference says that the sensors should have read, and how well it can be known.
#pragma once
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// Sets predicted, world_axis, position, rows and what is known of the reference's own noise; wakes rests through which
/// it moves; mutes what cannot be compared: rows in which the reference was lost, and motion too fast for it.
/// Pre: the readings and the rest are there, the recording has quaternions.
void predict(Signals& s, const io::Recording& recording, Eigen::Index rows_a_frame);

/// Mutes what stands so many rows or fewer beside a row in which the reference was lost.
void mute_beside_lost(Signals& s, Eigen::Index reach);

}  // namespace stillpoint::diag

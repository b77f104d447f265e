/// Rows of the simulator as a recording.
#pragma once
#include <string>

#include "io/recording.h"
#include "simulation/recorded_motion.h"
#include "simulation/simulator.h"

namespace stillpoint::io {

/// Adds one row. Columns that a row does not carry stay kMissing; reference columns are there when the first row has
/// them.
void append(const sim::SimulatedSample& row, Recording& to);

[[nodiscard]] Recording to_recording(const std::vector<sim::SimulatedSample>& rows);

/// Reference columns as a track for sim::RecordedMotion; rows without a reference orientation are left out.
[[nodiscard]] sim::ReferenceTrack reference_track(const Recording& recording);

/// Measured temperature, current and supply, on the clock of that track.
[[nodiscard]] sim::RecordedEnvironment recorded_environment(const Recording& recording);

}  // namespace stillpoint::io

/// Rows of the simulator as a recording.
#pragma once
#include <string>

#include "io/recording.h"
#include "simulation/simulator.h"

namespace stillpoint::io {

/// Adds one row. Columns that a row does not carry stay kMissing; reference columns are there when the first row has
/// them.
void append(const sim::SimulatedSample& row, Recording& to);

[[nodiscard]] Recording to_recording(const std::vector<sim::SimulatedSample>& rows);

}  // namespace stillpoint::io

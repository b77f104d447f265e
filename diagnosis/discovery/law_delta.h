/// What a law or table of a simulation does to one sensor, over the rows of a recording.
#pragma once
#include <optional>

#include "diagnosis/reference/signals.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// nullopt: the entry is no law or table, is another sensor's, or has a driver that the recording has not.
[[nodiscard]] std::optional<Series3> law_delta(const Signals& s, Sensor sensor, const sim::EffectConfig& entry);

}  // namespace stillpoint::diag

/// From the search's numbers to findings in words and units.
#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/reference/engine.h"
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// All of one sensor, strongest first. Effects of the whole clock are told by the sensor that sees them best.
void report_sensor(const Signals& s, const EngineResult& engine, Sensor sensor,
                   const std::vector<sim::EffectConfig>& given, Answer& answer);

/// In how many windows of one sensor effects act that do not last. Two or more are one cause that switches, not
/// recorded; two effects in the same window came and went together. What a stronger effect leaves in its own window or
/// at its edges, and what is weaker than a cause that lasts, are details and not counted.
[[nodiscard]] int locals(const SensorSearch& search);

}  // namespace stillpoint::diag

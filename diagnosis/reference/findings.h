/// From the search's numbers to findings in words and units.
#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/reference/engine.h"
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// All of one sensor, strongest first. Effects of the whole clock are told by the sensor that sees them best.
void report_sensor(const Signals& s, const EngineResult& engine, Sensor sensor,
                   const std::vector<sim::EffectConfig>& given, Answer& answer);

}  // namespace stillpoint::diag

/// Physics that the simulation has and the recording has not, or has of another size: a copied random walk, a wrong
/// time constant, an effect of another device. The missing is looked for in what is left without it.
#pragma once
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// Of each effect that can be predicted, how much of its configured size the recording holds; those that it holds
/// clearly less or more of are taken back out of the simulation. `bare`: the signals before the effects were
/// subtracted. Returns the effects that stay.
[[nodiscard]] std::vector<sim::EffectConfig> without_surplus(const Signals& bare,
                                                             const std::vector<sim::EffectConfig>& given,
                                                             Answer& answer);

/// What was taken out and found again with the numbers that it had is neither surplus nor missing.
void keep_what_was_right(const std::vector<sim::EffectConfig>& given, Answer& answer);

/// A random walk of the simulation (a number of the sensor, or an effect `*_drift`) that what is left of the recording
/// does not walk.
void report_surplus_walk(const SensorSearch& search, const Signals& s, const std::vector<sim::EffectConfig>& given,
                         Answer& answer);

}  // namespace stillpoint::diag

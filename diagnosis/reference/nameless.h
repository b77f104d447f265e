/// What no law explains: what switches, drifts, wanders at rest or swings there, or is left in motion.
#pragma once
#include <string>

#include "diagnosis/reference/evidence.h"
#include "diagnosis/result.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// The columns that the recording lacks and that could drive what this sensor shows, for a sentence; empty: none.
[[nodiscard]] std::string missing_drivers(const Signals& s, Sensor k);

/// What is left is no walk, whatever a walk gains. When is left to the caller.
[[nodiscard]] Finding remainder_finding(const SensorSearch& search);

/// Several events of one sensor, told as one: `first` is the strongest.
[[nodiscard]] Finding switching_finding(Finding first, const Signals& s, const SensorSearch& search);

[[nodiscard]] std::string drift_id(Sensor sensor);
[[nodiscard]] Finding drift_finding(const Signals& s, const SensorSearch& search, const Finished& finished);
[[nodiscard]] sim::EffectConfig drift_effect(Sensor sensor, const Finished& finished);

/// What differs from row to row for another reason says nothing of the noise.
void without_noise_of(Sensor k, Diagnosis& out);

/// What swings at rest is no white noise that the simulation could have: told in words, and taken out of the noise.
void tell_swings(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out);

/// Beside an exact reference, a sensor that moves is as quiet as one that rests once all is found: else a cause is
/// left.
void tell_left_in_motion(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out);

}  // namespace stillpoint::diag

/// Laws against a random walk that is there: "no driver survives once the random walk is in the noise model".
#pragma once
#include <optional>

#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// Whether what is left beside the found effects wanders more than the remainder of the largest of them could.
[[nodiscard]] bool drifts(const SensorSearch& search, const Finished& finished);

/// The finished model. Where it drifts, without the effects that are worth less than the freedom of their search once
/// the walk stands beside them: a slow driver resembles every drift a little, and any walk that the noise hides helps
/// it.
[[nodiscard]] Finished finish_beside_drift(SensorSearch& search);

/// Markers settle and a camera's calibration wanders by milliradians: of that size gravity and the field drift in the
/// body, not the sensors.
[[nodiscard]] bool reference_may_drift(const Signals& s, const SensorSearch& search, const Finished& finished);

/// A walk no faster than what the simulation has itself: its random walk, and its flicker, which passes for one within
/// minutes (equal powers at the period of the recording).
[[nodiscard]] bool walks_as_given(const Signals& s, Sensor sensor, const Finished& finished);

/// Beside an exact reference all that is left should be the sensor's noise: where more is, for a while or throughout;
/// none where it is not. `told`: with the noise as measured at rest.
[[nodiscard]] std::optional<Window> left_over(const Signals& s, const SensorSearch& search, const Finished& finished,
                                              const Diagnosis& told);

}  // namespace stillpoint::diag

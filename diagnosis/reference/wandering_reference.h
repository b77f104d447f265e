/// A camera whose calibration wanders, or whose markers settle, turns slowly against the sensors.
#pragma once
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// Whether the law is worth its charge beside a noisy reference that turns slowly by small angles: such angles times
/// the true vector go along with some product of drivers or other.
[[nodiscard]] bool stands_beside_wandering(const Signals& s, const SensorSearch& search, const Found& law);

/// Whether a random walk of the offset gains so many nats beside such turns.
[[nodiscard]] bool walks_beside_wandering(const Signals& s, const SensorSearch& search, double least_nats);

/// Whether a few milliradians of such a turn would do as much to the sensor as the law does.
[[nodiscard]] bool as_small_as_wandering(const Signals& s, const SensorSearch& search, const Found& law,
                                         const Fit& beside);

/// Whether an unknown law does next to nothing beside what a noisy reference leaves over, in the rows where it acts:
/// its errors are not white, and a trace of them goes along with some product of drivers.
[[nodiscard]] bool is_a_trace_of_the_cameras(const Signals& s, const SensorSearch& search, const Found& law,
                                             const Fit& beside);

}  // namespace stillpoint::diag

/// From a candidate of the scan to an effect with numbers: its window to the sample, its time constant between the
/// points of the grid, delays and filters on their exact response.
#pragma once
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// Moves the edges of a window to the sample: the prefix sum of the evidence has its turning points there.
[[nodiscard]] Window refine_window(const Target& target, const Columns& explained, const Law& law, const Candidate& c,
                                   const NoiseModel& noise);

[[nodiscard]] Found found_from(const Law& law, const Candidate& c, Columns columns);

/// The time constant between the points of the grid (beyond it at its ends) that explains most: golden section in its
/// logarithm, the noise given.
void refine_shape(const Target& target, const Columns& explained, const std::vector<double>& grid, Found& f);

/// The same for what was found before the last effect, each beside all the others, from where it stands: a time
/// constant or a frequency that was sought beside half of the physics would leave a law of its own over.
void refine_shapes_again(SensorSearch& search);

/// The timing laws, when the short list holds something that changes with the derivative of the measured vector. Their
/// gains are left to the caller.
[[nodiscard]] std::vector<Found> refine_timing(const Signals& s, const SensorSearch& search,
                                               const std::vector<Candidate>& shortlist, const NoiseModel& noise);

}  // namespace stillpoint::diag

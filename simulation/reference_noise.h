/// How much a reference must be smoothed, from its own noise: at rest the body does not move, so what the reference
/// does there is noise, whatever its colour; what it does in motion beyond that is motion.
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "simulation/smoothing_spline.h"

namespace stillpoint::sim {

/// First and last sample of a stretch.
using Span = std::pair<std::size_t, std::size_t>;

/// The penalty that leaves the least error in the `derivative`-th derivative: of the noise, with the spectrum it has in
/// the rests, what the spline passes, and of the motion, with the spectrum it has between them, what the spline takes.
/// That is the choice of Wiener's filter among the spline's. 0 where the rests are too short to measure a noise (two
/// pieces of 128 samples) or the body never moves. `samples` as measured, not flattened at rest.
template <int Columns>
[[nodiscard]] double penalty_against_noise(const CurveSamples<Columns>& samples, const std::vector<Span>& rests,
                                           double step_s, int derivative);

extern template double penalty_against_noise(const CurveSamples<3>&, const std::vector<Span>&, double, int);
extern template double penalty_against_noise(const CurveSamples<4>&, const std::vector<Span>&, double, int);

}  // namespace stillpoint::sim

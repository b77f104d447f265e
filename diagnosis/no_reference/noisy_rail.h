/// A rail beneath the noise: the element clips, and what comes after it adds noise, so that no two readings need be
/// alike. What shows it is that several excursions end at one level, flat, and come and go steeply.
#pragma once
#include <vector>

#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag::detail {

/// acc_sat and gyr_sat. Beneath the matrix of the simulation: across axes it bends what the element has cut flat.
[[nodiscard]] std::vector<Finding> find_noisy_rails(const io::Recording& recording,
                                                    const sim::SimulationConfig& simulation);

}  // namespace stillpoint::diag::detail

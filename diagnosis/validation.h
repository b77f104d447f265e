/// The improved simulation on a recording that it was not made from: how much of what the given one leaves is gone.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// One entry a sensor. Bias and matrix are fitted anew for both simulations: only the physics is compared. Empty where
/// the recording has no reference or is too short to compare.
[[nodiscard]] std::vector<Validation> validate(const std::string& file, const io::Recording& other,
                                               const sim::SimulationConfig& given,
                                               const sim::SimulationConfig& improved);

/// The effects that this sensor's entry in the simulation may be blamed for.
[[nodiscard]] bool acts_on(const std::string& effect, const std::string& sensor);

}  // namespace stillpoint::diag

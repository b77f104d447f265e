/// What a diagnosis makes of the simulation that it was given.
#pragma once
#include "diagnosis/diagnose.h"

namespace stillpoint::diag {

/// The simulation with the findings in it, its wrong numbers set right and its surplus physics taken out.
[[nodiscard]] sim::SimulationConfig improved_by(const Answer& answer, sim::SimulationConfig simulation);

}  // namespace stillpoint::diag

/// The whole diagnosis of one recording against one simulation: input checks, forensics on raw values, the search for
/// missing physics, and the answer of result.h.
#pragma once
#include <vector>

#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

struct Answer {
  Diagnosis diagnosis;
  std::vector<sim::EffectConfig>
      effects;  ///< the findings as entries for the simulation; findings without a law have none
};

/// Never fails: what cannot be judged is the verdict insufficient_data, with the reason among the notices.
/// Effects that the simulation already has are taken out before anything is looked for.
[[nodiscard]] Answer diagnose(const io::Recording& recording, const sim::SimulationConfig& simulation);

}  // namespace stillpoint::diag

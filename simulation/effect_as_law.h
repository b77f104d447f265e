/// Effects of the catalogue in the grammar of laws, for programs that have laws only: code to paste into another
/// simulator.
#pragma once
#include <vector>

#include "simulation/config.h"

namespace stillpoint::sim {

/// Laws that add together what this effect adds; empty where the grammar has no words for it. Pre: the ID is in the
/// catalogue, the counts are right.
[[nodiscard]] std::vector<EffectConfig> as_laws(const EffectConfig& effect);

}  // namespace stillpoint::sim

/// Physics that is not in the catalogue: where the engine ends at an unknown, or leaves much over, its products give
/// way to laws of the grammar.
#pragma once
#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// Replaces what the engine found in a sensor by laws that explain clearly more of it.
void discover(const Signals& s, EngineResult& engine);

}  // namespace stillpoint::diag

/// Laws against a random walk that is there: "no driver survives once the random walk is in the noise model".
#pragma once
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// Whether what is left beside the found effects wanders more than the remainder of the largest of them could.
[[nodiscard]] bool drifts(const SensorSearch& search, const Finished& finished);

/// The finished model. Where it drifts, without the effects that are worth less than the freedom of their search once
/// the walk stands beside them: a slow driver resembles every drift a little, and any walk that the noise hides helps
/// it.
[[nodiscard]] Finished finish_beside_drift(SensorSearch& search);

}  // namespace stillpoint::diag

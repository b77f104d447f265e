/// The bridge between what a diagnosis finds and the `effects:` of a simulation: a finding becomes an entry, and
/// entries that the simulation already has are taken out of the residual before anything is looked for.
#pragma once
#include "diagnosis/reference/selection.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// The found effect with its fitted values (one a coefficient or timing parameter) in the catalogue's keys.
/// nullopt: not in the catalogue, or not to be written in its keys. `s`: the rows it was found in.
[[nodiscard]] std::optional<sim::EffectConfig> to_effect(const Found& found, const Eigen::VectorXd& values,
                                                         const Signals& s);

/// Takes what the effects predict out of the residuals. Returns the IDs that cannot be predicted from the recording.
[[nodiscard]] std::vector<std::string> subtract_effects(Signals& s, const std::vector<sim::EffectConfig>& effects);

}  // namespace stillpoint::diag

/// A product of drivers that no name of the catalogue explains, as an entry of a simulation's `effects:`.
#pragma once
#include <optional>

#include "diagnosis/reference/selection.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// The entry for a finding `unknown:LAW` that lasts, with these coefficients in its order and their deviations: what is
/// not seen is 0. nullopt where what stands behind "unknown:" is no law.
[[nodiscard]] std::optional<sim::EffectConfig> law_entry(const Found& found, Sensor sensor,
                                                         const Eigen::VectorXd& values, const Eigen::VectorXd& sd);

}  // namespace stillpoint::diag

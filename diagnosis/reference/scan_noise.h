/// The noise beside which laws are sought (docs/decisions/182-the-noise-between-the-bursts.md).
#pragma once
#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

/// What is left after a flexible smooth model, so that the effect sought is not taken for noise.
[[nodiscard]] NoiseModel scan_noise(const Target& target, const Columns& explained, const Eigen::MatrixXd& walk);

}  // namespace stillpoint::diag

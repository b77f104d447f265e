/// How well a block of a recording is told by all the others.
#pragma once
#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

struct LeftOut {
  Eigen::VectorXd nats;  ///< per block: the logarithm of the density that the others give for it, but for a constant
  Series3 residual;      ///< of every row, with the coefficients of the others
};

/// With all that the others leave open: a coefficient that they hardly tell makes a wide density, not a wrong one
/// (Geisser and Eddy, JASA 74, 1979). `block`: rows of one. Of the coefficients nothing is known before.
[[nodiscard]] LeftOut blocks_left_out(const Target& t, const Columns& columns, const NoiseModel& noise,
                                      Eigen::Index block);

/// Per fold: how much greater the sum of its squared whitened deviations is to be expected with the coefficients of the
/// other folds than with those of the whole recording, where the model is true: sum of x' (C_others + C_all) x over its
/// rows. `fold_of_block`: for every block of so many rows.
[[nodiscard]] Eigen::VectorXd excess_of_others(const Target& t, const Columns& columns, const NoiseModel& noise,
                                               Eigen::Index block, const std::vector<int>& fold_of_block);

}  // namespace stillpoint::diag

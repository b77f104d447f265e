/// Rows that are left out of a fit together: blocks beside each other, or kinds of motion.
#pragma once
#include <vector>

#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

inline constexpr double kFold_s = 4.0;  ///< blocks beside each other, every second one left out

/// Which fold a row is left out in.
struct Folds {
  std::vector<int> of_row;
  int count = 2;
  Eigen::Index block = 1;  ///< rows that are in one fold
  bool of_regimes = false;
};

[[nodiscard]] Folds beside_each_other(const Target& t, double block_s = kFold_s, int count = 2);

/// Kinds of motion rather than pieces of it: what goes along with the true driver in one motion still does so half a
/// second later, in another it need not. `columns`: of the effects that are judged. Empty where one kind is nearly all.
[[nodiscard]] Folds by_regime(const Target& t, const Columns& columns);

/// The fold of every block.
[[nodiscard]] std::vector<int> fold_of_blocks(const Folds& folds);

}  // namespace stillpoint::diag

/// A rail that no reading lies on: clipped at the element, before a filter rounds its corners or noise is added.
#pragma once
#include <vector>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

struct HiddenRail {
  Series3 clipped;             ///< y, n x 3, unit of the reading: what the rail cuts
  std::vector<double> levels;  ///< to look from, ascending
};

/// Only a reference shows what is missing of a reading. One that scatters as much by itself would be taken for the
/// rail: beside it the reading stands for the true vector, and nothing is found.
[[nodiscard]] HiddenRail hidden_rail(const Signals& s, Sensor sensor);

}  // namespace stillpoint::diag

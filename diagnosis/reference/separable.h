/// Laws that this motion cannot tell from a wrong bias and matrix.
#pragma once
#include "diagnosis/reference/laws.h"

namespace stillpoint::diag {

/// False where a constant and the measured vector nearly span the columns. Under a noisy reference the little that is
/// left of them is its noise, which stands in the residual too: without translation every wrong gravity is a wrong
/// scale, and a camera's noise would decide between them. An exact reference separates whatever differs at all.
[[nodiscard]] bool is_separable(const Signals& s, Sensor sensor, const Columns& columns);

/// Drops the laws that are not.
void drop_inseparable(const Signals& s, Sensor sensor, std::vector<Law>& laws);

}  // namespace stillpoint::diag

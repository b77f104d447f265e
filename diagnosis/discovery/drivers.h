/// What a law may be made of: the drivers of one recording over its rows, in the words of the grammar.
#pragma once
#include <string>

#include "diagnosis/reference/signals.h"
#include "laws/evaluate.h"

namespace stillpoint::diag {

/// The vector that a sensor measures, as the grammar calls it: f, w, m.
[[nodiscard]] const char* own_vector(Sensor sensor);

/// Rates of the motion stand beside the drivers: over 17 rows they are known better than from row to row.
[[nodiscard]] laws::Columns drivers_of_rows(const Signals& s);

}  // namespace stillpoint::diag

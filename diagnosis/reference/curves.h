/// The curves behind a finding: its strongest channel in time, by frequency, against its driver, and after whitening.
#pragma once
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// Of effect `index` of the search; `finished` is the model with every effect in it. At most 2000 points a curve.
[[nodiscard]] FindingFigures curves_of(const Signals& s, const SensorSearch& search, std::size_t index,
                                       const Finished& finished);

}  // namespace stillpoint::diag

/// The curves behind a finding: its strongest channel in time, by frequency, against its driver, and after whitening.
#pragma once
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// Of effect `index` of the search; `finished` is the model with every effect in it. At most 2000 points a curve.
[[nodiscard]] FindingFigures curves_of(const Signals& s, const SensorSearch& search, std::size_t index,
                                       const Finished& finished);

/// One sensor's rows of the heat map, for the report: what the noise does not explain without the findings, in nats, by
/// channel and block of the noise's scale.
void heat_of(const Signals& s, const SensorSearch& search, Diagnosis& out);

}  // namespace stillpoint::diag

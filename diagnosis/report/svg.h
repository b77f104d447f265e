/// Figures of the report that need no script: drawn as SVG while the page is written.
#pragma once
#include <string>

#include "diagnosis/result.h"

namespace stillpoint::diag::svg {

/// Misfit of the baseline per channel and block of time; empty string without data.
[[nodiscard]] std::string heat_map(const Diagnosis& d);
/// Gains of the hypotheses with the line below which no name is stated.
[[nodiscard]] std::string ranking(const Diagnosis& d);
/// A parameter's interval on the catalogue's usual range, logarithmic in size.
[[nodiscard]] std::string parameter_range(const Parameter& p, double typical_low, double typical_high);

}  // namespace stillpoint::diag::svg

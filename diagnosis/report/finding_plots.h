/// The curves of a finding's card: before and after in time and frequency, against the driver, and what is left.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "report/plot.h"

namespace stillpoint::diag {

/// Headings and places of the plots of finding `k` of the page.
[[nodiscard]] std::string figures_html(const FindingFigures& figures, std::size_t k);

/// Those plots, and those of discovery_html().
[[nodiscard]] std::vector<report::Plot> finding_plots(const FindingFigures& figures, std::size_t k);

}  // namespace stillpoint::diag

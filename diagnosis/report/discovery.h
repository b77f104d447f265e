/// The part of a finding's card that lets an engineer judge a discovered law: what it is made of, what else was weighed
/// against it, and the residual against each of its quantities.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "report/plot.h"

namespace stillpoint::diag {

/// Of finding `k` of the page, with places for its discovery_plots() and the plots each-K-I of finding_plots(); empty
/// where its effect is no discovered law.
[[nodiscard]] std::string discovery_html(const Finding& finding, std::size_t k);
/// Gain over length of all that was weighed, the stated law apart; empty with fewer than three.
[[nodiscard]] std::vector<report::Plot> discovery_plots(const Finding& finding, std::size_t k);

}  // namespace stillpoint::diag

/// The part of a finding's card that lets an engineer judge a discovered law: what it is made of, what else was weighed
/// against it, and the residual against each of its quantities.
#pragma once
#include <string>

#include "diagnosis/result.h"

namespace stillpoint::diag {

/// Of finding `k` of the page, with places for the plots each-K-I of finding_plots(); empty where its effect is no
/// discovered law.
[[nodiscard]] std::string discovery_html(const Finding& finding, std::size_t k);

}  // namespace stillpoint::diag

/// The part of a finding's card that lets an engineer judge a discovered law: what it is made of, what else was weighed
/// against it, and the residual against each of its quantities.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "diagnosis/result.h"

namespace stillpoint::diag {

/// Of finding `k` of the page; empty where its effect is no discovered law.
[[nodiscard]] std::string discovery_html(const Finding& finding, std::size_t k);

/// Its curves, for the page's script.
[[nodiscard]] nlohmann::json discovery_data(const Finding& finding);

}  // namespace stillpoint::diag

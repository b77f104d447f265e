/// `stillpoint estimate --report`: the attitudes of recordings as a page, with what was stated of them, and beside the
/// reference where the recording has one.
#pragma once
#include <string>
#include <vector>

#include "apps/stillpoint/estimate_one.h"

namespace stillpoint::app {

[[nodiscard]] std::string estimates_html(const std::vector<EstimateRequest>& requests,
                                         const std::vector<Result<Estimated>>& estimated);

}  // namespace stillpoint::app

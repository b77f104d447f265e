/// What the plausibility check found, in words: what was seen, what it should be, the likely mistake, what to do.
#pragma once
#include <string>
#include <vector>

#include "core/plausibility.h"
#include "io/recording.h"

namespace stillpoint::io {

[[nodiscard]] std::string describe(const Finding& finding);

/// The check over a whole recording. Sensors in counts have no unit that could be wrong.
[[nodiscard]] std::vector<Finding> find_implausible(const Recording& recording);

}  // namespace stillpoint::io

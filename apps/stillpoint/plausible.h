/// Every command that reads a recording says when its units, its times or its sensors cannot be right.
#pragma once
#include <string>
#include <vector>

#include "core/plausibility.h"
#include "io/recording.h"

namespace stillpoint::app {

/// What was found, a line for each on standard error.
std::vector<Finding> warn_if_implausible(const io::Recording& recording, const std::string& path);

}  // namespace stillpoint::app

/// The log of somebody else's simulator: a recording of ours, or any table that `stillpoint import` reads.
#pragma once
#include <string>

#include "core/result.h"
#include "io/recording.h"

namespace stillpoint::app {

/// `map` (empty: none) says which columns are what. What was taken for what is told on standard error.
[[nodiscard]] Result<io::Recording> read_simulated_log(const std::string& path, const std::string& map);

}  // namespace stillpoint::app

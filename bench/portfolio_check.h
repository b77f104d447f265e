/// The portfolio's figures against stored ones: errors and coverage, set by set.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace stillpoint::bench {

/// `measured` as `portfolio --json` prints it, `way` "causal" or "smoothed". Says what is behind and what was not
/// compared; the exit code: 0, 1 behind, 78 no such limits.
[[nodiscard]] int check_portfolio(const nlohmann::json& measured, const std::string& limits_file,
                                  const std::string& way);

}  // namespace stillpoint::bench

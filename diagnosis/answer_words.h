/// How an answer's parts are written, in a diagnosis and in a campaign alike.
#pragma once
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "diagnosis/result.h"

namespace stillpoint::diag {

/// JSON has no infinity or NaN.
[[nodiscard]] inline nlohmann::json number(double x) {
  return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr);
}

[[nodiscard]] inline nlohmann::json share_json(double share, const std::array<double, 2>& ci95) {
  return {{"share", number(share)}, {"ci95", {number(ci95[0]), number(ci95[1])}}};
}

[[nodiscard]] inline nlohmann::json parameter_json(const Parameter& p) {
  return {
      {"name", p.name}, {"value", number(p.value)}, {"ci95", {number(p.ci95[0]), number(p.ci95[1])}}, {"unit", p.unit}};
}

/// "         k_x = +0.001 +- 2e-05 rad/s/K"
[[nodiscard]] inline std::string parameter_text(const Parameter& p) {
  return fmt::format("         {} = {:+.4g} +- {:.2g} {}", p.name, p.value, 0.5 * (p.ci95[1] - p.ci95[0]), p.unit);
}

}  // namespace stillpoint::diag

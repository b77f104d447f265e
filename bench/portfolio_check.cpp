#include "bench/portfolio_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace stillpoint::bench {
namespace {

/// What of one set is behind its limits: errors in degrees are at most, shares inside at least, what is stored.
bool behind(const std::string& name, const nlohmann::json& measured, const nlohmann::json& limits) {
  bool any = false;
  for (const auto& [figure, limit] : limits.items()) {
    const double value = measured.at(figure), allowed = limit;
    const bool share = figure.ends_with("inside");
    if (share ? value >= allowed : value <= allowed) continue;
    fmt::print(stderr, "REGRESSED {}: {} is {:.4g}, {} {:.4g} is stored\n", name, figure, value,
               share ? "at least" : "at most", allowed);
    any = true;
  }
  return any;
}

std::string name_of(const nlohmann::json& entry) {
  return entry.contains("set") ? entry.at("set").get<std::string>()
                               : fmt::format("gap of {} s", entry.at("gap_s").get<double>());
}

}  // namespace

int check_portfolio(const nlohmann::json& measured, const std::string& limits_file, const std::string& way) {
  std::ifstream in(limits_file);
  const nlohmann::json file = nlohmann::json::parse(in, nullptr, false);
  if (!file.is_object() || !file.contains(way)) {
    fmt::print(stderr, "{}: no limits of '{}' here\n", limits_file, way);
    return 78;
  }
  nlohmann::json entries = measured.at("sets");
  if (measured.contains("gaps")) entries.insert(entries.end(), measured.at("gaps").begin(), measured.at("gaps").end());
  bool any = false;
  std::size_t compared = 0;
  for (const auto& [name, limits] : file.at(way).items()) {
    const auto entry =
        std::find_if(entries.begin(), entries.end(), [&](const nlohmann::json& e) { return name_of(e) == name; });
    if (entry == entries.end()) {
      fmt::print(stderr, "NOT COMPARED: {} is not here\n", name);
      continue;
    }
    any |= behind(name, *entry, limits);
    ++compared;
  }
  fmt::print(stderr, "{} sets compared with {}: {}\n", compared, limits_file, any ? "behind" : "none behind");
  return any || compared == 0 ? 1 : 0;
}

}  // namespace stillpoint::bench

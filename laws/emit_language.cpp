#include "laws/emit_language.h"

#include <fmt/format.h>

namespace stillpoint::laws {

std::string Dialect::number(double x) const {
  std::string out = fmt::format("{}", x);
  if (out.find_first_of(".en") == std::string::npos) out += ".0";
  return x < 0.0 ? "(" + out + ")" : out;
}

std::string Dialect::list(const std::vector<double>& values) const {
  std::string out;
  for (const double x : values) out += (out.empty() ? "" : ", ") + number(x);
  return out;
}

std::string Dialect::rows(const std::array<std::vector<double>, 3>& values, char open, char close) const {
  std::string out;
  for (const auto& row : values)
    out += fmt::format("{}{}{}{}", out.empty() ? "" : ",\n        ", open, list(row), close);
  return open + out + close;
}

std::string Dialect::numbers(const Coupled& law, std::size_t first, std::size_t count) const {
  const auto begin = law.matrix.begin() + static_cast<std::ptrdiff_t>(first);
  return list({begin, begin + static_cast<std::ptrdiff_t>(count)});
}

std::vector<std::string> Dialect::words(const Coupled& law, const Names& drivers) const {
  const char* makes = law.table        ? "what a table has (beyond its points the end value) at"
                      : law.has_matrix ? "a matrix times"
                                       : "k times";
  std::vector<std::string> out{fmt::format("Adds to the {} (in {}), row by row: {}", law.sensor, law.unit, makes),
                               "  " + text(law.tree),
                               "t: seconds, increasing" + std::string(drivers.empty() ? "" : "; drivers:")};
  out.insert(out.begin() + 2, law.beside.begin(), law.beside.end());
  for (const auto& [name, vector] : drivers) {
    const auto info = standard_drivers().find(name);
    const bool known = info != standard_drivers().end();
    out.push_back(fmt::format("  {}: {}{}{}", name, known ? info->second.words : "column of the recording",
                              known && !info->second.unit.plain() ? " in " + text(info->second.unit) : "",
                              vector ? ", three axes of the sensor" : ""));
  }
  return out;
}

}  // namespace stillpoint::laws

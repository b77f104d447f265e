#include "diagnosis/reference/driver_unit.h"

#include <algorithm>
#include <map>

namespace stillpoint::diag {
namespace {

/// One factor: f, f_z, |f|, |f_i|, f^2, dw/dt, (T-T0), I, (V-V0). Empty: it has none, as offset(t).
std::string factor_unit(std::string factor) {
  std::string power;
  if (const auto hat = factor.find('^'); hat != std::string::npos) {
    power = factor.substr(hat);
    factor.resize(hat);
  }
  std::erase(factor, '|');
  if (const auto axis = factor.find('_'); axis != std::string::npos) factor.resize(axis);
  static const std::map<std::string, std::string> units{{"f", "m/s^2"},  {"w", "rad/s"}, {"dw/dt", "rad/s^2"},
                                                        {"m", "uT"},     {"I", "A"},     {"(V-V0)", "V"},
                                                        {"(T-T0)", "K"}, {"dT/dt", "K"}};
  const auto at = units.find(factor);
  if (at == units.end()) return {};
  const bool compound = at->second.find('/') != std::string::npos;
  return power.empty() ? at->second : (compound ? "(" + at->second + ")" : at->second) + power;
}

}  // namespace

std::string coefficient_unit(const std::string& of, const std::string& driver) {
  if (driver == "field(p)") return of + "/m";
  if (driver == "dw/dt x r + w x (w x r)") return "m";
  if (driver == "m(t)") return "1";
  std::string product;
  for (std::size_t from = 0; from <= driver.size();) {
    const std::size_t to = std::min(driver.find('*', from), driver.size());
    const std::string unit = factor_unit(driver.substr(from, to - from));
    if (!unit.empty()) product += (product.empty() ? "" : " ") + unit;
    from = to + 1;
  }
  return product.empty() ? of : of + " per " + product;
}

}  // namespace stillpoint::diag

#include "calib_online/state_fields.h"

#include <cmath>
#include <vector>

namespace stillpoint::calib {
namespace {

/// Variances that are none, or a correlation beyond one.
bool is_covariance(std::span<const double> lower, int rows) {
  const auto at = [&](int i, int j) { return lower[static_cast<std::size_t>(i * (i + 1) / 2 + j)]; };
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j <= i; ++j)
      if (at(i, i) < 0.0 || at(i, j) * at(i, j) > 1.001 * at(i, i) * at(j, j) + 1e-30) return false;
  return true;
}

std::string short_number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

}  // namespace

std::string fault_of(const FieldOfState& field, std::span<const double> values) {
  for (const double v : values)
    if (!std::isfinite(v) || !field.range.holds(v))
      return std::string(field.name) + ": " + short_number(v) + " is outside " + short_number(field.range.low) +
             " to " + short_number(field.range.high);
  if (field.covariance > 0 && !is_covariance(values, field.covariance))
    return std::string(field.name) + ": is no covariance";
  return {};
}

std::string fault_of(const OnlineCalibrator::State& state) {
  std::string fault;
  visit_state(state, [&fault](const FieldOfState& field, const auto& member) {
    if (!fault.empty()) return;
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(member)>>) {
      const double value = static_cast<double>(member);
      fault = fault_of(field, std::span(&value, 1));
    } else {
      fault = fault_of(field, member);
    }
  });
  return fault;
}

}  // namespace stillpoint::calib

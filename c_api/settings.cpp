#include "c_api/settings.h"

#include <cmath>
#include <cstdio>
#include <type_traits>

#include "core/fields.h"
#include "core/nearest.h"

namespace stillpoint::c_api {
namespace {

/// Calls visit(name, value, range) for every number and flag of the parts, its name with the prefix before it.
template <class P, class Visit>
void each_field(P& params, const std::string& prefix, const Visit& visit) {
  const auto one = [&](const auto& f) {
    auto& value = params.*(f.member);
    using T = std::remove_reference_t<decltype(value)>;
    const std::string name = prefix + std::string(f.name);
    if constexpr (HasFields<T>)
      each_field(value, name + ".", visit);
    else if constexpr (std::is_arithmetic_v<T>)
      visit(name, value, f.range);
  };
  std::apply([&](const auto&... f) { (one(f), ...); }, std::remove_const_t<P>::fields());
}

template <class Visit>
void each_setting(Settings& s, const Visit& visit) {
  each_field(s.stages.guard, "sensor.limits.", visit);
  each_field(s.stages.rest, "rest.", visit);
  visit("calibration.enabled", s.stages.learn, finite());
  visit("calibration.answer_delay_s", s.stages.answer_delay_s, in_range(0.0, 10.0));
  each_field(s.calibrator, "calibration.online.", visit);
  each_field(s.stages.attitude, "attitude.", visit);
  visit("output.initial_heading_rad", s.stages.initial_heading_rad, in_range(-3.15, 3.15));
  visit("stale_after_s", s.stale_after_s, in_range(0.01, 3600.0));
}

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", x);
  return buffer;
}

/// Empty, or why `to` cannot be this value.
template <class T>
std::string assign(T& to, double value, const Range& range) {
  if constexpr (std::is_same_v<T, bool>) {
    if (value != 0.0 && value != 1.0) return "is a flag: 0 or 1, not " + text(value);
    to = value == 1.0;
  } else {
    if (!range.holds(value)) return text(value) + " is outside " + text(range.low) + " ... " + text(range.high);
    if constexpr (std::is_integral_v<T>) {
      if (value != std::floor(value) || std::abs(value) > 2e9) return "is a whole number, not " + text(value);
      to = static_cast<T>(value);
    } else {
      to = value;
    }
  }
  return "";
}

}  // namespace

std::vector<std::string> setting_names() {
  std::vector<std::string> names;
  Settings defaults;
  each_setting(defaults, [&](const std::string& name, auto&, const Range&) { names.push_back(name); });
  return names;
}

std::string set(Settings& settings, std::string_view name, double value) {
  bool found = false;
  std::string fault;
  each_setting(settings, [&](const std::string& known, auto& to, const Range& range) {
    if (known != name) return;
    found = true;
    fault = assign(to, value, range);
  });
  if (found) return fault.empty() ? "" : std::string(name) + ": " + fault;
  const auto names = setting_names();
  const auto meant = nearest(name, names);
  return "no setting '" + std::string(name) + "'" +
         (meant.empty() ? "; docs/configuration.md lists them" : "; did you mean '" + std::string(meant) + "'?");
}

std::string check(const Settings& settings) { return calib::check(settings.calibrator); }

}  // namespace stillpoint::c_api

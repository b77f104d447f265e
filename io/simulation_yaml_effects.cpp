/// One entry of an `effects:` list, read and checked against the catalogue.
#include <algorithm>
#include <cmath>

#include "io/quote.h"
#include "io/simulation_yaml.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::io {
namespace {

using sim::EffectConfig;
using Names = std::vector<std::string>;

void read_axes(const YAML::Node& node, std::vector<int>& out, YamlFaults& faults) {
  if (!node.IsSequence() || node.size() == 0) return faults.add(node, "'axes' must be a list such as [x, z]");
  for (const auto& item : node) {
    const std::string name = item.IsScalar() ? item.Scalar() : "";
    if (name != "x" && name != "y" && name != "z") {
      faults.add(item, quote(name) + " is not an axis; use x, y or z");
    } else if (const int axis = name[0] - 'x'; std::find(out.begin(), out.end(), axis) != out.end()) {
      faults.add(item, fmt::format("axis '{}' stands twice", name));
    } else {
      out.push_back(axis);
    }
  }
}

void read_window(const YAML::Node& node, std::optional<std::pair<double, double>>& out, YamlFaults& faults) {
  std::vector<double> ends;
  if (!node.IsSequence() || node.size() != 2) return faults.add(node, "'window_s' must be [start, end]");
  if (!reads(node, ends, finite(), "window_s", faults)) return;
  if (ends.size() != 2) return faults.add(node, "'window_s' must be [start, end]");
  if (ends[0] >= ends[1]) return faults.add(node, "'window_s' must start before it ends");
  out = {ends[0], ends[1]};
}

void read_parameter(const YAML::Node& node, const sim::EffectParameter& p, EffectConfig& out, YamlFaults& faults) {
  std::vector<double> values;
  if (!reads(node, values, in_range(-1e9, 1e9), p.key, faults)) return;  // beyond it numbers stop being numbers
  const auto wanted = static_cast<std::size_t>(p.count);
  if (wanted == 3 && values.size() == 1) values.resize(3, values[0]);
  if (values.size() != wanted)
    return faults.add(node, fmt::format("'{}' has {} number{}, {} takes {} ({})", p.key, values.size(),
                                        values.size() == 1 ? "" : "s", out.id, wanted,
                                        wanted == 9   ? "a 3x3 matrix, row by row"
                                        : wanted == 3 ? "x, y, z"
                                                      : p.unit));
  out.parameters[p.key] = std::move(values);
}

void read_sensors(const YAML::Node& node, const sim::EffectInfo& info, EffectConfig& out, YamlFaults& faults) {
  if (!info.takes_sensors())
    return faults.add(node, fmt::format("'sensors' has no meaning for {}, which has its one place; the effects of the "
                                        "whole sensor block (sys_* but for sys_tracker, ref_frame) take it",
                                        out.id));
  if (!node.IsSequence() || node.size() == 0) return faults.add(node, "'sensors' must be a list such as [acc, gyr]");
  for (const auto& item : node) {
    const std::string name = item.IsScalar() ? item.Scalar() : "";
    const auto* const known = std::find_if(std::begin(sim::kSensors), std::end(sim::kSensors),
                                           [&](sim::Sensor s) { return name == sim::prefix(s); });
    if (known == std::end(sim::kSensors))
      faults.add(item, quote(name) + " is not a sensor; use acc, gyr or mag");
    else if (std::find(out.sensors.begin(), out.sensors.end(), *known) != out.sensors.end())
      faults.add(item, fmt::format("sensor '{}' stands twice", name));
    else
      out.sensors.push_back(*known);
  }
}

/// What the simulator cannot give a meaning to.
void check_effect(const YAML::Node& entry, const EffectConfig& e, YamlFaults& faults) {
  const auto refuse_unless = [&](std::initializer_list<const char*> keys, auto&& good, const std::string& must) {
    for (const char* key : keys)
      if (const auto it = e.parameters.find(key);
          it != e.parameters.end() && !std::all_of(it->second.begin(), it->second.end(), good))
        faults.add(entry[key], fmt::format("'{}' must be {}", key, must));
  };
  const auto positive = [](double x) { return x > 0.0; };
  const bool shift_in_time = e.id.ends_with("_delay") || e.id == "sys_offset";  // may be negative: ahead of its time
  if (!shift_in_time) refuse_unless({"tau_s"}, positive, "greater than 0");
  refuse_unless({"f_hz", "average_s", "L_mps2", "L_radps", "L_uT", "band_hz", "limit_radps"}, positive,
                "greater than 0");
  refuse_unless(
      {"q_mps2", "q_radps", "q_uT"}, [](double q) { return q >= 1e-12; }, "greater than 0, at least 1e-12");
  refuse_unless(
      {"d_radps", "sd_s", "orientation_sd_rad", "position_sd_m"}, [](double x) { return x >= 0.0; }, "0 or greater");
  refuse_unless(
      {"eps_ppm"}, [](double x) { return x > -1e6; }, "above -1e6: there the clock stands still");
  if (e.id == "mag_hold")  // of a file that was resampled a value lasts 2.8 rows on average
    refuse_unless(
        {"n"}, [](double n) { return n >= 1.0 && n <= 1e6; }, "1 to 1e6 samples");
  else  // below 0: rows that were put in
    refuse_unless(
        {"n"}, [](double n) { return n == std::floor(n) && n != 0.0 && std::abs(n) <= 1e6; },
        "a whole number of samples, 1 to 1e6, or below 0 where samples were put in");
  refuse_unless(
      {"zeta"}, [](double z) { return z > 0.0 && z < 1.0; },
      "between 0 and 1: beyond 1 nothing resonates, use a low-pass");
  refuse_unless(
      {"fraction"}, [](double x) { return x >= 0.0 && x <= 1.0; }, "between 0 and 1");
  refuse_unless(
      {"hidden"}, [](double x) { return x == 0.0 || x == 1.0; }, "0 or 1");
  refuse_unless(
      {"side"}, [](double x) { return x == 0.0 || std::abs(x) == 1.0; }, "1 (only above), -1 (only below) or 0 (both)");
}

}  // namespace

void read_effect(const YAML::Node& entry, EffectConfig& out, YamlFaults& faults) {
  if (!entry.IsMap() || !entry["effect"] || !entry["effect"].IsScalar())
    return faults.add(entry, "expected {effect: ID, parameters...}; docs/effects.md lists the IDs");
  out.id = entry["effect"].Scalar();
  if (out.id == "law" || out.id == "table") return read_written_effect(entry, out, faults);
  const sim::EffectInfo* info = sim::find_effect(out.id);
  if (info == nullptr) {
    Names ids;
    for (const auto& e : sim::effect_catalogue()) ids.push_back(e.id);
    return faults.add(entry["effect"], fmt::format("unknown effect {}{}", quote(out.id), suggestion(out.id, ids)));
  }
  Names known{"effect", "axes", "sensors", "window_s"};
  for (const auto& p : info->parameters) known.push_back(p.key);
  refuse_unknown_keys(entry, known, faults);
  for (const auto& p : info->parameters) {
    if (const YAML::Node node = entry[p.key])
      read_parameter(node, p, out, faults);
    else if (p.required)
      faults.add(entry, fmt::format("{} needs '{}' ({}, {})", out.id, p.key,
                                    p.count == 9   ? "3x3 numbers"
                                    : p.count == 3 ? "three numbers"
                                                   : "one number",
                                    p.unit));
  }
  if (const YAML::Node node = entry["axes"]) read_axes(node, out.axes, faults);
  if (const YAML::Node node = entry["sensors"]) read_sensors(node, *info, out, faults);
  if (const YAML::Node node = entry["window_s"]) read_window(node, out.window_s, faults);
  check_effect(entry, out, faults);
}

}  // namespace stillpoint::io

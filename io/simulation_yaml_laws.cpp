/// Entries `{effect: law, ...}` and `{effect: table, ...}` of an `effects:` list.
#include <algorithm>
#include <limits>

#include "io/quote.h"
#include "io/simulation_yaml.h"
#include "simulation/law_effect.h"

namespace stillpoint::io {
namespace {

using sim::EffectConfig;

constexpr double kLargestNumber = 1e12;

bool read_sensor(const YAML::Node& entry, EffectConfig& out, YamlFaults& faults) {
  const YAML::Node node = entry["sensor"];
  const std::string name = node && node.IsScalar() ? node.Scalar() : "";
  for (const sim::Sensor s : sim::kSensors)
    if (name == sim::prefix(s)) out.sensors = {s};
  if (out.sensors.empty()) faults.add(node ? node : entry, "'sensor' must say what the law adds to: acc, gyr or mag");
  return !out.sensors.empty();
}

/// The expression; nullopt when a fault was told.
std::optional<laws::Node> read_expression(const YAML::Node& entry, const char* key, EffectConfig& out,
                                          YamlFaults& faults) {
  const YAML::Node node = entry[key];
  if (!node || !node.IsScalar()) {
    faults.add(entry, fmt::format("'{}' is missing: an expression in quotes, as in \"norm(w) * (T - 25)\"", key));
    return std::nullopt;
  }
  const bool table = std::string_view(key) == "driver";
  out.id = std::string(table ? sim::kTablePrefix : sim::kLawPrefix) + node.Scalar();
  auto tree = sim::tree_of(out);
  if (!tree) {
    faults.add(node, fmt::format("'{}', column {}: {}", key, tree.error().column, printable(tree.error().what, 500)));
    return std::nullopt;
  }
  return std::move(*tree);
}

bool reads_numbers(const YAML::Node& node, std::vector<double>& out, const std::string& key, YamlFaults& faults) {
  return reads(node, out, in_range(-kLargestNumber, kLargestNumber), key, faults);
}

void read_coupling(const YAML::Node& entry, const laws::Node& tree, EffectConfig& out, YamlFaults& faults) {
  const YAML::Node k = entry["k"], matrix = entry["matrix"];
  if (static_cast<bool>(k) == static_cast<bool>(matrix))
    return faults.add(entry, "a law needs either 'k' (x, y, z) or, for a vector, 'matrix' (3x3)");
  std::vector<double> values;
  if (k) {
    if (!reads_numbers(k, values, "k", faults)) return;
    if (values.size() == 1) values.resize(3, values[0]);
    if (values.size() != 3) return faults.add(k, fmt::format("'k' has {} numbers, not 3 (x, y, z)", values.size()));
    out.parameters["k"] = std::move(values);
    return;
  }
  if (!tree.vector)
    return faults.add(matrix,
                      "a matrix times a number has no meaning: the law is a number; give 'k', or make it a vector");
  if (!reads_numbers(matrix, values, "matrix", faults)) return;
  if (values.size() != 9) return faults.add(matrix, fmt::format("'matrix' has {} numbers, not 3x3", values.size()));
  out.parameters["matrix"] = std::move(values);
}

void read_times(const YAML::Node& entry, EffectConfig& out, YamlFaults& faults) {
  constexpr double kEver = std::numeric_limits<double>::max();
  if (const YAML::Node tau = entry["tau_s"]) {
    double value = 1.0;
    read_value(tau, value, in_range(1e-6, 1e9), "tau_s", faults);
    out.parameters["tau_s"] = {value};
  }
  double from = -kEver, to = kEver;
  if (const YAML::Node node = entry["from_s"])
    read_value(node, from, in_range(-kLargestNumber, kLargestNumber), "from_s", faults);
  if (const YAML::Node node = entry["to_s"])
    read_value(node, to, in_range(-kLargestNumber, kLargestNumber), "to_s", faults);
  if (from >= to) return faults.add(entry["to_s"], "'to_s' must be later than 'from_s'");
  if (from > -kEver || to < kEver) out.window_s = {from, to};
}

void read_curves(const YAML::Node& entry, EffectConfig& out, YamlFaults& faults) {
  const YAML::Node x = entry["x"], y = entry["y"];
  if (!x || !y) return faults.add(entry, "a table needs 'x' (increasing) and 'y' (three rows, one an axis)");
  auto& points = out.parameters["x"];
  const bool good_x = reads_numbers(x, points, "x", faults);
  if (!reads_numbers(y, out.parameters["y"], "y", faults) || !good_x) return;
  const std::size_t n = points.size();
  if (n < 2) return faults.add(x, "'x' needs two points at least");
  if (std::adjacent_find(points.begin(), points.end(), std::greater_equal<>()) != points.end())
    faults.add(x, "'x' must increase from point to point");
  if (out.parameters["y"].size() != 3 * n)
    faults.add(y, fmt::format("'y' has {} numbers; three rows of {} are due, one value a point of 'x'",
                              out.parameters["y"].size(), n));
  bool clamp = false;
  if (const YAML::Node node = entry["clamp"]) read_value(node, clamp, {}, "clamp", faults);
  if (clamp) out.parameters["clamp"] = {1.0};
}

std::string list(const std::vector<double>& v, std::size_t first, std::size_t count) {
  return fmt::format("[{}]", fmt::join(v.begin() + static_cast<std::ptrdiff_t>(first),
                                       v.begin() + static_cast<std::ptrdiff_t>(first + count), ", "));
}

std::string rows(const std::vector<double>& v) {
  const std::size_t n = v.size() / 3;
  return fmt::format("[{}, {}, {}]", list(v, 0, n), list(v, n, n), list(v, 2 * n, n));
}

}  // namespace

void read_written_effect(const YAML::Node& entry, EffectConfig& out, YamlFaults& faults) {
  const bool table = entry["effect"].Scalar() == "table";
  if (table)
    refuse_unknown_keys(entry, {"effect", "sensor", "driver", "x", "y", "clamp", "from_s", "to_s"}, faults);
  else
    refuse_unknown_keys(entry, {"effect", "sensor", "law", "k", "matrix", "tau_s", "from_s", "to_s"}, faults);
  read_sensor(entry, out, faults);
  const auto tree = read_expression(entry, table ? "driver" : "law", out, faults);
  read_times(entry, out, faults);
  if (table)
    read_curves(entry, out, faults);
  else if (tree)
    read_coupling(entry, *tree, out, faults);
}

std::string format_written_effect(const EffectConfig& e) {
  const bool table = sim::is_table(e);
  std::string out = fmt::format("{{effect: {}, sensor: {}, {}: \"{}\"", table ? "table" : "law",
                                sim::prefix(e.sensors.front()), table ? "driver" : "law", sim::expression_of(e));
  for (const auto& [key, values] : e.parameters) {
    if (key == "clamp")
      out += ", clamp: true";
    else if (key == "matrix" || key == "y")
      out += fmt::format(", {}: {}", key, rows(values));
    else
      out +=
          fmt::format(", {}: {}", key, key == "tau_s" ? fmt::format("{}", values[0]) : list(values, 0, values.size()));
  }
  constexpr double kEver = std::numeric_limits<double>::max();
  if (e.window_s && e.window_s->first > -kEver) out += fmt::format(", from_s: {}", e.window_s->first);
  if (e.window_s && e.window_s->second < kEver) out += fmt::format(", to_s: {}", e.window_s->second);
  return out + "}";
}

}  // namespace stillpoint::io

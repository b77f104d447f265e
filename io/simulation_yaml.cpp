#include "io/simulation_yaml.h"

#include <algorithm>
#include <fstream>

#include "simulation/effect_catalogue.h"

namespace stillpoint::io {
namespace {

using sim::EffectConfig;
using sim::SimulationConfig;
using sim::TriadConfig;

struct TriadKeys {
  const char* key;
  const char* unit;
  std::optional<TriadConfig> SimulationConfig::*member;
};
constexpr TriadKeys kTriads[] = {{"accelerometer", "mps2", &SimulationConfig::accelerometer},
                                 {"gyroscope", "radps", &SimulationConfig::gyroscope},
                                 {"magnetometer", "uT", &SimulationConfig::magnetometer}};

void read_triad(const YAML::Node& map, const std::string& unit, TriadConfig& out, YamlFaults& faults) {
  if (!map.IsMap()) return faults.add(map, "expected {bias: [...], matrix: [...], noise_" + unit + ": ...}");
  const std::string noise = "noise_" + unit, instability = "bias_instability_" + unit;
  const std::string walk = "random_walk_" + unit + "_per_sqrts";
  refuse_unknown_keys(map, {"bias", "matrix", noise, "noise_axes", "noise_band_hz", instability, walk, "rate_hz"},
                      faults);
  const auto read = [&](const std::string& key, auto& value, const Range& range) {
    if (const YAML::Node node = map[key]) read_value(node, value, range, key, faults);
  };
  const Range size = in_range(0.0, 1e6);
  read("bias", out.bias, finite());
  read("matrix", out.matrix, finite());
  read(noise, out.noise_sd, size);
  read("noise_axes", out.noise_axes, size);
  read("noise_band_hz", out.noise_band_hz, size);
  read(instability, out.bias_instability, size);
  read(walk, out.random_walk_per_sqrts, size);
  read("rate_hz", out.rate_hz, size);
  if (std::abs(out.matrix.determinant()) < 1e-6)
    faults.add(map["matrix"], "'matrix' cannot be inverted, so no reading y belongs to a corrected reading u");
}

void read_axes(const YAML::Node& node, std::vector<int>& out, YamlFaults& faults) {
  if (!node.IsSequence() || node.size() == 0) return faults.add(node, "'axes' must be a list such as [x, z]");
  for (const auto& item : node) {
    const std::string name = item.IsScalar() ? item.Scalar() : "";
    if (name != "x" && name != "y" && name != "z") {
      faults.add(item, fmt::format("'{}' is not an axis; use x, y or z", name));
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
  read_value(node, ends, finite(), "window_s", faults);
  if (ends.size() != 2) return;
  if (ends[0] >= ends[1]) return faults.add(node, "'window_s' must start before it ends");
  out = {ends[0], ends[1]};
}

void read_parameter(const YAML::Node& node, const sim::EffectParameter& p, EffectConfig& out, YamlFaults& faults) {
  std::vector<double> values;
  const std::size_t before = faults.messages().size();
  read_value(node, values, finite(), p.key, faults);
  if (faults.messages().size() != before) return;
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

void read_extent(const YAML::Node& entry, const sim::EffectInfo& info, EffectConfig& out, YamlFaults& faults) {
  if (const YAML::Node node = entry["axes"]; node && !info.takes_axes())
    faults.add(node,
               fmt::format("'axes' has no meaning for {}, which moves whole sensors; the effects acc_*, gyr_* and "
                           "mag_* (but for *_delay) and sys_tracker take it",
                           out.id));
  else if (node)
    read_axes(node, out.axes, faults);
  if (const YAML::Node node = entry["window_s"]; node && !info.takes_window())
    faults.add(node, fmt::format("'window_s' has no meaning for {}, which holds throughout; the effects acc_*, gyr_*, "
                                 "mag_* and sys_* take it",
                                 out.id));
  else if (node)
    read_window(node, out.window_s, faults);
}

/// What the simulator cannot give a meaning to.
void check_effect(const YAML::Node& entry, const EffectConfig& e, YamlFaults& faults) {
  const auto positive_only = {"tau_s", "f_hz",   "zeta",    "average_s", "L_mps2",  "L_radps",
                              "L_uT",  "q_mps2", "q_radps", "q_uT",      "band_hz", "limit_radps"};
  for (const char* key : positive_only)
    if (const auto it = e.parameters.find(key);
        it != e.parameters.end() && (e.id.ends_with("_delay") || e.id == "sys_offset") == false)
      if (*std::min_element(it->second.begin(), it->second.end()) <= 0.0)
        faults.add(entry[key], fmt::format("'{}' must be greater than 0", key));
  if (e.id == "mag_hold" || e.id == "sys_gap")
    if (const auto it = e.parameters.find("n"); it != e.parameters.end())
      if (it->second[0] != std::floor(it->second[0]) || it->second[0] < 1 || it->second[0] > 1e6)
        faults.add(entry["n"], "'n' must be a whole number of samples, at least 1");
  if (const auto it = e.parameters.find("zeta"); it != e.parameters.end() && it->second[0] >= 1.0)
    faults.add(entry["zeta"], "'zeta' must be below 1: beyond it nothing resonates, use a low-pass");
  if (const auto it = e.parameters.find("fraction");
      it != e.parameters.end() && (it->second[0] < 0 || it->second[0] > 1))
    faults.add(entry["fraction"], "'fraction' must be between 0 and 1");
}

void read_environment(const YAML::Node& node, SimulationConfig& c, bool gravity_given, YamlFaults& faults);

template <class Kinds>
void check_kind(const YAML::Node& block, const std::string& kind, const Kinds& known, YamlFaults& faults) {
  if (std::find(known.begin(), known.end(), kind) != known.end()) return;
  faults.add(block["kind"], fmt::format("'{}' is not a kind known here{}", kind, suggestion(kind, known)));
}

using Names = std::vector<std::string>;

void read_motion(const YAML::Node& node, SimulationConfig& c, YamlFaults& faults) {
  if (node.IsNull()) return;
  auto& m = c.motion.emplace();
  read_fields(node, m, faults);
  if (!node.IsMap()) return;
  check_kind(node, m.kind, sim::motion_kind_names(), faults);
  if (m.min_bout_s > m.max_bout_s) faults.add(node, "'min_bout_s' is longer than 'max_bout_s'");
  if (m.min_rest_s > m.max_rest_s) faults.add(node, "'min_rest_s' is longer than 'max_rest_s'");
}

void read_environment(const YAML::Node& node, SimulationConfig& c, bool gravity_given, YamlFaults& faults) {
  read_fields(node, c.environment, faults);
  if (!node.IsMap()) return;
  if (const YAML::Node t = node["temperature"])
    check_kind(t, c.environment.temperature.kind, Names{"constant", "warm_up", "chamber", "day", "activity"}, faults);
  if (const YAML::Node i = node["current"])
    check_kind(i, c.environment.current.kind, Names{"off", "steps", "activity"}, faults);
  if (!gravity_given && node["latitude_rad"])
    c.gravity_mps2 = sim::normal_gravity_mps2(c.environment.latitude_rad, c.environment.height_m);
}

Result<SimulationConfig> read_root(const YAML::Node& root, const std::string& name) {
  YamlFaults faults(name);
  SimulationConfig c;
  refuse_unknown_keys(root,
                      {"rate_hz", "gravity_mps2", "field_world_uT", "accelerometer", "gyroscope", "magnetometer",
                       "effects", "motion", "environment", "timing", "reference"},
                      faults);
  if (const YAML::Node n = root["rate_hz"]) read_value(n, c.rate_hz, in_range(0.1, 1e5), "rate_hz", faults);
  if (const YAML::Node n = root["gravity_mps2"])
    read_value(n, c.gravity_mps2, in_range(0.1, 100.0), "gravity_mps2", faults);
  if (const YAML::Node n = root["field_world_uT"]) read_value(n, c.field_world_uT, finite(), "field_world_uT", faults);
  for (const auto& t : kTriads)
    if (const YAML::Node n = root[t.key]) read_triad(n, t.unit, (c.*t.member).emplace(), faults);
  if (!c.accelerometer && !c.gyroscope && !c.magnetometer)
    faults.add(root, "no sensor: at least one of accelerometer, gyroscope, magnetometer is needed");
  if (const YAML::Node n = root["effects"]; n && !n.IsNull()) {
    if (!n.IsSequence())
      faults.add(n, "'effects' must be a list of {effect: ID, ...}");
    else
      for (const auto& item : n) read_effect(item, c.effects.emplace_back(), faults);
  }
  if (const YAML::Node n = root["motion"]) read_motion(n, c, faults);
  if (const YAML::Node n = root["environment"]) read_environment(n, c, static_cast<bool>(root["gravity_mps2"]), faults);
  if (const YAML::Node n = root["timing"]) read_fields(n, c.timing, faults);
  if (const YAML::Node n = root["reference"]) {
    read_fields(n, c.reference, faults);
    if (n.IsMap()) check_kind(n, c.reference.kind, Names{"exact", "mocap", "none"}, faults);
  }
  if (!faults.empty()) return faults.error();
  return c;
}

std::string number(double x) {
  const std::string shortest = fmt::format("{}", x);
  return shortest;
}

template <class Values>
std::string list(const Values& values) {
  std::string out = "[";
  for (const double x : values) out += (out.size() > 1 ? ", " : "") + number(x);
  return out + "]";
}

std::string list(const Vec3& v) { return list(array(v)); }
std::string matrix(const Mat3& m) {
  std::string out = "[";
  for (int row = 0; row < 3; ++row) out += (row > 0 ? ", " : "") + list(Vec3(m.row(row)));
  return out + "]";
}

std::string emit(double x) { return number(x); }
std::string emit(int x) { return fmt::format("{}", x); }
std::string emit(const std::string& x) { return x; }
std::string emit(const Vec3& x) { return list(x); }
template <HasFields P>
std::string emit(const P& value);
template <HasFields P>
std::string emit(const std::vector<P>& values) {
  std::string out;
  for (const P& v : values) out += (out.empty() ? "" : ", ") + emit(v);
  return "[" + out + "]";
}
/// Flow map of the fields that differ from their defaults.
template <HasFields P>
std::string emit(const P& value) {
  const P plain;
  std::string out;
  const auto one = [&](const auto& f) {
    const std::string text = emit(value.*(f.member));
    if (f.name == "kind" || text != emit(plain.*(f.member)))
      out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", f.name, text);
  };
  std::apply([&](const auto&... f) { (one(f), ...); }, P::fields());
  return "{" + out + "}";
}

std::string format_triad(const TriadConfig& t, const std::string& unit) {
  std::string out =
      fmt::format("{{bias: {}, matrix: {}, noise_{}: {}", list(t.bias), matrix(t.matrix), unit, number(t.noise_sd));
  if (t.noise_axes != Vec3::Ones()) out += ", noise_axes: " + list(t.noise_axes);
  const auto add = [&out](const std::string& key, double value) {
    if (value != 0.0) out += fmt::format(", {}: {}", key, number(value));
  };
  add("noise_band_hz", t.noise_band_hz);
  add("bias_instability_" + unit, t.bias_instability);
  add("random_walk_" + unit + "_per_sqrts", t.random_walk_per_sqrts);
  add("rate_hz", t.rate_hz);
  return out + "}";
}

}  // namespace

void read_effect(const YAML::Node& entry, EffectConfig& out, YamlFaults& faults) {
  if (!entry.IsMap() || !entry["effect"] || !entry["effect"].IsScalar())
    return faults.add(entry, "expected {effect: ID, parameters...}; docs/effects.md lists the IDs");
  out.id = entry["effect"].Scalar();
  const sim::EffectInfo* info = sim::find_effect(out.id);
  if (info == nullptr) {
    Names ids;
    for (const auto& e : sim::effect_catalogue()) ids.push_back(e.id);
    return faults.add(entry["effect"], fmt::format("unknown effect '{}'{}", out.id, suggestion(out.id, ids)));
  }
  Names known{"effect", "axes", "window_s"};
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
  read_extent(entry, *info, out, faults);
  check_effect(entry, out, faults);
}

Result<SimulationConfig> read_simulation(const std::string& path) {
  const auto root = load_yaml(path);
  if (!root) return tl::unexpected(root.error());
  return read_root(*root, path);
}

Result<SimulationConfig> parse_simulation(const std::string& text, const std::string& name) {
  const auto root = parse_yaml(text, name);
  if (!root) return tl::unexpected(root.error());
  return read_root(*root, name);
}

std::string format_effect(const EffectConfig& e) {
  std::string out = "{effect: " + e.id;
  for (const auto& [key, values] : e.parameters) {
    if (values.size() == 1) {
      out += fmt::format(", {}: {}", key, number(values[0]));
    } else if (values.size() == 9) {
      Array9 m{};
      std::copy(values.begin(), values.end(), m.begin());
      out += fmt::format(", {}: {}", key, matrix(mat(m)));
    } else {
      out += fmt::format(", {}: {}", key, list(values));
    }
  }
  if (!e.axes.empty()) {
    out += ", axes: [";
    for (std::size_t i = 0; i < e.axes.size(); ++i) out += fmt::format("{}{}", i > 0 ? ", " : "", "xyz"[e.axes[i]]);
    out += "]";
  }
  if (e.window_s) out += fmt::format(", window_s: [{}, {}]", number(e.window_s->first), number(e.window_s->second));
  return out + "}";
}

std::string format_simulation(const SimulationConfig& c) {
  std::string out = fmt::format("rate_hz: {}\ngravity_mps2: {}\nfield_world_uT: {}\n", number(c.rate_hz),
                                number(c.gravity_mps2), list(c.field_world_uT));
  for (const auto& t : kTriads)
    if (const auto& triad = c.*t.member) out += fmt::format("{}: {}\n", t.key, format_triad(*triad, t.unit));
  out += c.effects.empty() ? "effects: []\n" : "effects:\n";
  for (const auto& e : c.effects) out += "  - " + format_effect(e) + "\n";
  if (c.motion) out += "motion: " + emit(*c.motion) + "\n";
  const auto block = [&out](const char* key, const std::string& text, const std::string& plain) {
    if (text != plain) out += fmt::format("{}: {}\n", key, text);
  };
  block("environment", emit(c.environment), emit(sim::EnvironmentConfig{}));
  block("timing", emit(c.timing), emit(sim::TimingConfig{}));
  block("reference", emit(c.reference), emit(sim::ReferenceConfig{}));
  return out;
}

Result<void> write_simulation(const SimulationConfig& config, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  if (!file) return fail(ErrorKind::kCannotCreate, fmt::format("{}: cannot be created; does the folder exist?", path));
  file << format_simulation(config);
  file.flush();
  if (!file)
    return fail(ErrorKind::kCannotCreate, fmt::format("{}: could not be written whole; is the disk full?", path));
  return {};
}

}  // namespace stillpoint::io

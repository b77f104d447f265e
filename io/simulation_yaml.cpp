#include "io/simulation_yaml.h"

#include <algorithm>

#include "io/quote.h"

namespace stillpoint::io {
namespace {

using sim::SimulationConfig;
using sim::TriadConfig;

constexpr int kMostFrames = 32;  // bits in the simulator's mask of frames

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
  read("bias", out.bias, in_range(-1e9, 1e9));
  read("matrix", out.matrix, in_range(-1e6, 1e6));
  read(noise, out.noise_sd, size);
  read("noise_axes", out.noise_axes, size);
  read("noise_band_hz", out.noise_band_hz, size);
  read(instability, out.bias_instability, size);
  read(walk, out.random_walk_per_sqrts, size);
  read("rate_hz", out.rate_hz, size);
  if (std::abs(out.matrix.determinant()) < 1e-6)
    faults.add(map["matrix"], "'matrix' cannot be inverted, so no reading y belongs to a corrected reading u");
}

template <class Kinds>
void check_kind(const YAML::Node& block, const std::string& kind, const Kinds& known, YamlFaults& faults) {
  if (std::find(known.begin(), known.end(), kind) != known.end()) return;
  faults.add(block["kind"], fmt::format("{} is not a kind known here{}", quote(kind), suggestion(kind, known)));
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
  // A motion of bouts and rests is drawn beforehand: each takes half a kilobyte of memory.
  constexpr double kMostBouts = 1e6;
  const double bout_s = m.kind == "rest_poses" ? m.move_s : m.min_bout_s;
  if (const double bouts = m.duration_s / (bout_s + m.min_rest_s); bouts > kMostBouts)
    faults.add(node, fmt::format("{:.0f} bouts may come in 'duration_s', more than {:.0f}; make bouts or rests longer",
                                 bouts, kMostBouts));
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
  refuse_unknown_keys(root, simulation_keys(), faults);
  if (const YAML::Node n = root["rate_hz"]) read_value(n, c.rate_hz, in_range(0.1, 1e5), "rate_hz", faults);
  if (const YAML::Node n = root["gravity_mps2"])
    read_value(n, c.gravity_mps2, in_range(0.1, 100.0), "gravity_mps2", faults);
  if (const YAML::Node n = root["field_world_uT"])
    read_value(n, c.field_world_uT, in_range(-1e6, 1e6), "field_world_uT", faults);
  for (const auto& t : kTriads)
    if (const YAML::Node n = root[t.key]) read_triad(n, t.unit, (c.*t.member).emplace(), faults);
  if (!c.accelerometer && !c.gyroscope && !c.magnetometer)
    faults.add(root, "no sensor: at least one of accelerometer, gyroscope, magnetometer is needed");
  if (const YAML::Node n = root["effects"]; n && !n.IsNull()) {
    if (!n.IsSequence())
      faults.add(n, "'effects' must be a list of {effect: ID, ...}");
    else
      for (const auto& item : n) read_effect(item, c.effects.emplace_back(), faults);
    if (const auto frames =
            std::count_if(c.effects.begin(), c.effects.end(), [](const auto& e) { return e.id == "ref_frame"; });
        frames > kMostFrames)
      faults.add(n, fmt::format("{} entries of ref_frame; {} at most", frames, kMostFrames));
  }
  if (const YAML::Node n = root["motion"]) read_motion(n, c, faults);
  if (const YAML::Node n = root["environment"]) read_environment(n, c, static_cast<bool>(root["gravity_mps2"]), faults);
  if (const YAML::Node n = root["timing"]) read_fields(n, c.timing, faults);
  if (const YAML::Node n = root["reference"]) {
    read_fields(n, c.reference, faults);
    c.reference.stated = !n.IsMap() || n.size() > (n["latency_s"] ? 1U : 0U);
    if (n.IsMap()) check_kind(n, c.reference.kind, Names{"exact", "mocap", "none"}, faults);
  }
  if (!faults.empty()) return faults.error();
  return c;
}

}  // namespace

const std::vector<std::string>& simulation_keys() {
  static const Names keys{"rate_hz", "gravity_mps2", "field_world_uT", "accelerometer", "gyroscope", "magnetometer",
                          "effects", "motion",       "environment",    "timing",        "reference"};
  return keys;
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

}  // namespace stillpoint::io

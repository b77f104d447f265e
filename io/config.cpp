#include "io/config.h"

#include <filesystem>

#include "core/directions.h"
#include "io/simulation_yaml.h"
#include "simulation/law_effect.h"

namespace stillpoint::io {
namespace {

constexpr std::size_t kLongestId = 100;   // a file's name ends at 255 bytes, and suffixes come on
constexpr double kLeastGainRatio = 1e-6;  // of a matrix's smallest to its largest gain

const Words<pipeline::WorldFrame> kWorldFrames{{"enu", pipeline::WorldFrame::kEnu},
                                               {"ned", pipeline::WorldFrame::kNed}};

/// An effect of the compensate list, and where its numbers go.
struct Compensated {
  const char* id;
  const char* key;
  Vec3 pipeline::Compensation::*member;
};
using C = pipeline::Compensation;
constexpr Compensated kVectors[] = {{"acc_temp_lin", "k_mps2_per_K", &C::acc_per_K},
                                    {"acc_temp_quad", "k1_mps2_per_K", &C::acc_per_K},
                                    {"acc_temp_quad", "k2_mps2_per_K2", &C::acc_per_K2},
                                    {"acc_asym", "k", &C::acc_asym},
                                    {"acc_quad", "k2_per_mps2", &C::acc_quad},
                                    {"acc_cubic", "k3_per_mps2_2", &C::acc_cubic},
                                    {"acc_lever", "r_m", &C::acc_lever_m},
                                    {"gyr_temp_lin", "k_radps_per_K", &C::gyr_per_K},
                                    {"gyr_temp_quad", "k1_radps_per_K", &C::gyr_per_K},
                                    {"gyr_temp_quad", "k2_radps_per_K2", &C::gyr_per_K2},
                                    {"gyr_asym", "k", &C::gyr_asym},
                                    {"gyr_cubic", "k3_per_radps_2", &C::gyr_cubic},
                                    {"mag_temp_lin", "k_uT_per_K", &C::mag_per_K}};
constexpr const char* kOthers[] = {"gyr_gsens", "mag_delay"};

bool is_causal(const std::string& id) {
  return std::any_of(std::begin(kVectors), std::end(kVectors), [&](const auto& c) { return id == c.id; }) ||
         std::any_of(std::begin(kOthers), std::end(kOthers), [&](const auto& c) { return id == c; });
}

/// A law that has no memory and no driver but what the stages know of a moment.
bool is_momentary(const laws::Node& law) {
  const auto names = laws::drivers_of(law);
  return laws::memoryless(law) && std::all_of(names.begin(), names.end(), [](const std::string& n) {
           return n == "w" || n == "f" || n == "m" || n == "T";
         });
}

bool is_causal(const sim::EffectConfig& effect) {
  if (!sim::is_law(effect)) return is_causal(effect.id);
  const auto tree = sim::tree_of(effect);
  return tree && is_momentary(*tree);
}

Vec3 driver_of(const pipeline::Momentary& now, std::string_view name) {
  if (name == "f") return now.force;
  if (name == "w") return now.rate;
  return name == "m" ? now.field : Vec3(Vec3::Constant(now.temp_degC));
}

pipeline::TakenOutLaw taken_out(const sim::EffectConfig& effect) {
  using pipeline::Momentary;
  static constexpr Vec3 Momentary::*kOf[] = {&Momentary::force, &Momentary::rate, &Momentary::field};
  const laws::Coupled law = sim::coupled(effect);
  const Mat3 matrix = law.has_matrix ? Mat3(mat(law.matrix)) : Mat3(Vec3(law.matrix.data()).asDiagonal());
  return {kOf[static_cast<std::size_t>(effect.sensors.front())],
          [matrix, stream = laws::Stream(law.tree)](const Momentary& now) mutable -> Vec3 {
            return matrix * stream.next([&now](std::string_view name, double) { return driver_of(now, name); }, 0.0);
          }};
}

std::string list_of_compensated() {
  std::set<std::string> ids(std::begin(kOthers), std::end(kOthers));
  for (const auto& c : kVectors) ids.insert(c.id);
  return fmt::format("{}", fmt::join(ids, ", "));
}

std::string why_not(const sim::EffectConfig& effect) {
  if (sim::is_law(effect))
    return fmt::format(
        "the law '{}' cannot be taken out of the readings in real time: it may use w, f, m and T as they "
        "are at that moment, no memory (lag, delay, play, d, integral), time, supply or current",
        sim::expression_of(effect));
  return fmt::format("'{}' cannot be taken out of the readings in real time; what can: a law, {}", effect.id,
                     list_of_compensated());
}

/// Pre: read_effect found no fault. Effects of one kind add up.
void add_effect(const sim::EffectConfig& effect, pipeline::Compensation& out) {
  const auto number = [&](const std::string& key, std::size_t i) {
    const auto found = effect.parameters.find(key);
    if (found == effect.parameters.end() || found->second.empty()) return 0.0;
    return found->second[found->second.size() == 1 ? 0 : i];
  };
  const auto on = [&](int axis) {
    return effect.axes.empty() || std::find(effect.axes.begin(), effect.axes.end(), axis) != effect.axes.end();
  };
  for (const auto& c : kVectors) {
    if (effect.id != c.id) continue;
    for (int i = 0; i < 3; ++i)
      if (on(i)) (out.*c.member)[i] += number(c.key, static_cast<std::size_t>(i));
  }
  if (effect.id == "gyr_gsens") {
    for (int i = 0; i < 9; ++i)
      if (on(i / 3)) out.gyr_gsens(i / 3, i % 3) += number("G_radps_per_mps2", static_cast<std::size_t>(i));
  }
  if (sim::is_law(effect)) {
    auto laws = out.laws ? *out.laws : std::vector<pipeline::TakenOutLaw>{};
    laws.push_back(taken_out(effect));
    out.laws = std::make_shared<const std::vector<pipeline::TakenOutLaw>>(std::move(laws));
  }
  if (effect.id == "mag_delay") out.mag_delay_s += number("tau_s", 0);
  out.any = true;
}

/// Pre: read_fields found no fault, so what these values are read from are maps.
void check_sensor(const SensorConfig& sensor, const YAML::Node& root, YamlFaults& faults) {
  const YAML::Node node = root["sensor"];
  const std::string& id = sensor.id;
  const bool plain = std::none_of(id.begin(), id.end(),
                                  [](char c) { return c == '/' || std::iscntrl(static_cast<unsigned char>(c)) != 0; });
  if (id.empty() || id[0] == '.' || id.size() > kLongestId || !plain)
    faults.add(node["id"],
               fmt::format("'id' names the file of the calibration: 1 to {} characters, without '/' and control "
                           "characters, not beginning with '.'",
                           kLongestId));
  const auto invertible = [&](const char* key, const TriadFactory& triad) {
    const Vec3 gains = singular_values(triad.matrix);
    if (!(gains[2] > kLeastGainRatio * gains[0]))
      faults.add(node[key]["matrix"], "'matrix' takes different readings to the same value: it has no inverse");
  };
  invertible("accelerometer", sensor.accelerometer);
  invertible("gyroscope", sensor.gyroscope);
  invertible("magnetometer", sensor.magnetometer);
}

/// Paths are relative to the folder of the configuration. Pre: read_fields found no fault in the block.
void finish_security(SecurityParams& security, const YAML::Node& root, const std::string& name, YamlFaults& faults) {
  if (!is_secured(security)) return;
  const auto from_here = [&name](std::string& path) {
    if (!path.empty() && std::filesystem::path(path).is_relative())
      path = (std::filesystem::path(name).parent_path() / path).lexically_normal().string();
  };
  from_here(security.folder);
  for (const auto& file : kSecurityFiles) from_here(security.*file.path);
  for (const auto& what : check(security)) faults.add(root["dds"]["security"], what);
}

Result<DaemonConfig> interpret(const YAML::Node& root, const std::string& name) {
  DaemonConfig config;
  YamlFaults faults(name);
  read_fields(root, config, faults);
  finish_source(config.source, root, name, faults);
  for (const auto& what : check(config.dds)) faults.add(root["dds"], what);
  finish_security(config.dds.security, root, name, faults);
  if (const std::string what = calib::check(config.calibration.online); !what.empty())
    faults.add(root["calibration"]["online"]["temperature_model"], what);
  if (!faults.empty()) return faults.error();
  check_sensor(config.sensor, root, faults);
  if (!faults.empty()) return faults.error();
  return config;
}

}  // namespace

void read_value(const YAML::Node& node, pipeline::WorldFrame& out, const Range&, const std::string& key,
                YamlFaults& faults) {
  read_word(node, out, kWorldFrames, key, faults);
}

void read_value(const YAML::Node& node, std::optional<double>& out, const Range& range, const std::string& key,
                YamlFaults& faults) {
  double value = 0.0;
  if (reads(node, value, range, key, faults)) out = value;
}

void read_value(const YAML::Node& node, std::vector<sim::EffectConfig>& out, const Range&, const std::string& key,
                YamlFaults& faults) {
  if (!node.IsSequence()) return faults.add(node, fmt::format("'{}' must be a list of {{effect: ID, ...}}", key));
  for (const auto& entry : node) {
    sim::EffectConfig effect;
    const std::size_t before = faults.messages().size();
    read_effect(entry, effect, faults);
    if (faults.messages().size() != before) continue;
    if (!is_causal(effect))
      faults.add(entry, why_not(effect));
    else if (effect.window_s)
      faults.add(entry["window_s"], "'window_s' has no meaning here: a compensation is always in force");
    else
      out.push_back(effect);
  }
}

bool can_be_compensated(const sim::EffectConfig& effect) { return is_causal(effect) && !effect.window_s; }

Result<DaemonConfig> parse_config(const std::string& text, const std::string& name) {
  const auto root = parse_yaml(text, name);
  if (!root) return tl::unexpected(root.error());
  return interpret(*root, name);
}

Result<DaemonConfig> read_config(const std::string& path) {
  const auto root = load_yaml(path);
  if (!root) return tl::unexpected(root.error());
  return interpret(*root, path);
}

CalibrationSnapshot factory_calibration(const SensorConfig& sensor) {
  CalibrationSnapshot factory;
  const auto set = [](TriadCalibration& out, const TriadFactory& in) {
    out.bias = array(in.bias);
    out.bias_per_K = array(in.bias_per_K);
    out.bias_per_K2 = array(in.bias_per_K2);
    out.temp_ref_degC = in.temp_ref_degC;
    out.temp_min_degC = in.temp_min_degC;
    out.temp_max_degC = std::max(in.temp_min_degC, in.temp_max_degC);
    out.matrix = array(in.matrix);
  };
  set(factory.acc, sensor.accelerometer);
  set(factory.gyr, sensor.gyroscope);
  set(factory.mag, sensor.magnetometer);
  return factory;
}

pipeline::StagesParams stages_params(const DaemonConfig& config) {
  pipeline::StagesParams p;
  p.guard = config.sensor.limits;
  p.rest = config.rest;
  p.attitude = config.attitude;
  for (const auto& effect : config.compensate) add_effect(effect, p.compensation);
  p.frame = {config.output.world_frame, Quat(config.output.mount.R_body_sensor)};
  p.initial_heading_rad = config.output.initial_heading_rad;
  p.answer_delay_s = config.calibration.answer_delay_s;
  p.learn = config.calibration.enabled;
  return p;
}

}  // namespace stillpoint::io

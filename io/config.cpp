#include "io/config.h"

#include <Eigen/SVD>
#include <filesystem>
#include <sstream>

#include "io/quote.h"
#include "io/simulation_yaml.h"

namespace stillpoint::io {
namespace {

constexpr std::size_t kLongestId = 100;   // a file's name ends at 255 bytes, and suffixes come on
constexpr double kLeastGainRatio = 1e-6;  // of a matrix's smallest to its largest gain

/// One of a few words.
template <class E>
void read_word(const YAML::Node& node, E& out, const std::vector<std::pair<std::string, E>>& words,
               const std::string& key, YamlFaults& faults) {
  std::vector<std::string> known;
  for (const auto& [word, value] : words) {
    if (node.IsScalar() && node.Scalar() == word) {
      out = value;
      return;
    }
    known.push_back(word);
  }
  const std::string given = node.IsScalar() ? node.Scalar() : "";
  faults.add(node, fmt::format("'{}' cannot be {}{}", key, node.IsScalar() ? quote(given) : "a list or a map",
                               suggestion(given, known)));
}

const std::vector<std::pair<std::string, SourceKind>> kSourceKinds{{"recording", SourceKind::kRecording},
                                                                   {"simulation", SourceKind::kSimulation}};
const std::vector<std::pair<std::string, SourceEnd>> kSourceEnds{{"stop", SourceEnd::kStop},
                                                                 {"wait", SourceEnd::kWait}};
const std::vector<std::pair<std::string, pipeline::WorldFrame>> kWorldFrames{{"enu", pipeline::WorldFrame::kEnu},
                                                                             {"ned", pipeline::WorldFrame::kNed}};

/// "+x -z +y": body x is the sensor's +x, body y its -z, body z its +y. None: not three signed axes.
std::optional<Mat3> mount_of_names(const std::string& text) {
  std::istringstream words(text);
  Mat3 R = Mat3::Zero();
  std::string word;
  for (Eigen::Index row = 0; row < 3; ++row) {
    if (!(words >> word)) return std::nullopt;
    if (word.size() == 1) word.insert(word.begin(), '+');
    if (word.size() != 2 || (word[0] != '+' && word[0] != '-') || word[1] < 'x' || word[1] > 'z') return std::nullopt;
    R(row, word[1] - 'x') = word[0] == '+' ? 1.0 : -1.0;
  }
  return words >> word ? std::nullopt : std::optional(R);
}

Mat3 nearest_rotation(const Mat3& M) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 signs = Mat3::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs(2, 2) = -1.0;
  return svd.matrixU() * signs * svd.matrixV().transpose();
}

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

std::string list_of_compensated() {
  std::set<std::string> ids(std::begin(kOthers), std::end(kOthers));
  for (const auto& c : kVectors) ids.insert(c.id);
  return fmt::format("{}", fmt::join(ids, ", "));
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
  if (effect.id == "mag_delay") out.mag_delay_s += number("tau_s", 0);
  out.any = true;
}

/// Rules between fields.
void check_source(const SourceConfig& source, const YAML::Node& root, YamlFaults& faults) {
  const YAML::Node node = root["source"];
  if (!node || !node.IsMap()) return;
  if (!node["kind"]) faults.add(node, "'kind' is missing here: recording or simulation");
  if (!node["file"])
    faults.add(node, "'file' is missing here: the recording (.csv) or the simulation (.yaml) to take samples from");
  else if (source.file.empty())
    faults.add(node["file"], "'file' is empty");
}

void check_rest(const DaemonConfig& config, const YAML::Node& root, YamlFaults& faults) {
  if (config.calibration.answer_delay_s >= config.rest.window_s)
    faults.add(
        root["calibration"] ? root["calibration"] : root,
        fmt::format(
            "'answer_delay_s' ({}) must be shorter than a rest window, 'rest: window_s' ({}): one answer at a time",
            config.calibration.answer_delay_s, config.rest.window_s));
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
    const Eigen::JacobiSVD<Mat3> svd(triad.matrix);
    if (!(svd.singularValues()(2) > kLeastGainRatio * svd.singularValues()(0)))
      faults.add(node[key]["matrix"], "'matrix' takes different readings to the same value: it has no inverse");
  };
  invertible("accelerometer", sensor.accelerometer);
  invertible("gyroscope", sensor.gyroscope);
  invertible("magnetometer", sensor.magnetometer);
}

Result<DaemonConfig> interpret(const YAML::Node& root, const std::string& name) {
  DaemonConfig config;
  YamlFaults faults(name);
  read_fields(root, config, faults);
  check_source(config.source, root, faults);
  check_rest(config, root, faults);
  for (const auto& what : check(config.dds)) faults.add(root["dds"], what);
  if (const std::string what = calib::check(config.calibration.online); !what.empty())
    faults.add(root["calibration"]["online"]["temperature_model"], what);
  if (!faults.empty()) return faults.error();
  check_sensor(config.sensor, root, faults);
  if (!faults.empty()) return faults.error();
  const std::filesystem::path file(config.source.file);
  if (!file.empty() && file.is_relative())
    config.source.file = (std::filesystem::path(name).parent_path() / file).lexically_normal().string();
  return config;
}

}  // namespace

void read_value(const YAML::Node& node, SourceKind& out, const Range&, const std::string& key, YamlFaults& faults) {
  read_word(node, out, kSourceKinds, key, faults);
}
void read_value(const YAML::Node& node, SourceEnd& out, const Range&, const std::string& key, YamlFaults& faults) {
  read_word(node, out, kSourceEnds, key, faults);
}
void read_value(const YAML::Node& node, pipeline::WorldFrame& out, const Range&, const std::string& key,
                YamlFaults& faults) {
  read_word(node, out, kWorldFrames, key, faults);
}

void read_value(const YAML::Node& node, std::optional<double>& out, const Range& range, const std::string& key,
                YamlFaults& faults) {
  double value = 0.0;
  const std::size_t before = faults.messages().size();
  read_value(node, value, range, key, faults);
  if (faults.messages().size() == before) out = value;
}

void read_value(const YAML::Node& node, Mount& out, const Range&, const std::string& key, YamlFaults& faults) {
  Mat3 R = Mat3::Identity();
  if (node.IsScalar()) {
    const auto named = mount_of_names(node.Scalar());
    if (!named)
      return faults.add(node, fmt::format("'{}' must be three signed axes such as \"+x -z +y\", or three rows", key));
    R = *named;
  } else {
    const std::size_t before = faults.messages().size();
    read_value(node, R, finite(), key, faults);
    if (faults.messages().size() != before) return;
  }
  const Mat3 nearest = nearest_rotation(R);
  if ((R - nearest).norm() > 1e-3) {
    const char* why = R.determinant() < 0.0 ? "mirrors (left-handed)" : "is not a rotation";
    return faults.add(
        node, fmt::format("'{}' {}; the nearest rotation is [[{:.4g}, {:.4g}, {:.4g}], [{:.4g}, {:.4g}, {:.4g}], "
                          "[{:.4g}, {:.4g}, {:.4g}]]",
                          key, why, nearest(0, 0), nearest(0, 1), nearest(0, 2), nearest(1, 0), nearest(1, 1),
                          nearest(1, 2), nearest(2, 0), nearest(2, 1), nearest(2, 2)));
  }
  out.R_body_sensor = nearest;
}

void read_value(const YAML::Node& node, std::vector<sim::EffectConfig>& out, const Range&, const std::string& key,
                YamlFaults& faults) {
  if (!node.IsSequence()) return faults.add(node, fmt::format("'{}' must be a list of {{effect: ID, ...}}", key));
  for (const auto& entry : node) {
    sim::EffectConfig effect;
    const std::size_t before = faults.messages().size();
    read_effect(entry, effect, faults);
    if (faults.messages().size() != before) continue;
    if (!is_causal(effect.id))
      faults.add(entry, fmt::format("'{}' cannot be taken out of the readings in real time; what can: {}", effect.id,
                                    list_of_compensated()));
    else if (effect.window_s)
      faults.add(entry["window_s"], "'window_s' has no meaning here: a compensation is always in force");
    else
      out.push_back(effect);
  }
}

bool can_be_compensated(const sim::EffectConfig& effect) { return is_causal(effect.id) && !effect.window_s; }

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

#include "exchange/parameters.h"

#include <fmt/format.h>

#include <algorithm>

#include "exchange/parameters_of.h"
#include "io/simulation_yaml.h"

namespace stillpoint::exchange {

namespace parameters {

std::array<Part, 3> parts_of(const sim::SimulationConfig& s) {
  return {{{"accelerometer", sim::Sensor::kAcc, &s.accelerometer},
           {"gyroscope", sim::Sensor::kGyr, &s.gyroscope},
           {"magnetometer", sim::Sensor::kMag, &s.magnetometer}}};
}

void lose_effects(const sim::SimulationConfig& s, const std::vector<std::string>& held,
                  std::vector<std::string>& lost) {
  for (const sim::EffectConfig& e : s.effects)
    if (std::find(held.begin(), held.end(), e.id) == held.end()) lost.push_back("effect " + e.id);
}

const sim::EffectConfig* entry_of(const sim::SimulationConfig& s, const std::string& id) {
  const auto at = std::find_if(s.effects.begin(), s.effects.end(), [&](const auto& e) { return e.id == id; });
  return at == s.effects.end() ? nullptr : &*at;
}

Vec3 three(const sim::EffectConfig* entry, const std::string& key) {
  if (entry == nullptr || !entry->parameters.contains(key)) return Vec3::Zero();
  const std::vector<double>& v = entry->parameters.at(key);
  return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : Vec3(v.empty() ? Vec3::Zero() : Vec3::Constant(v[0]));
}

void add_effect(sim::SimulationConfig& s, const std::string& id, const std::string& key, const Vec3& v) {
  if (v.isZero(0.0)) return;
  sim::EffectConfig e;
  e.id = id;
  e.parameters[key] = {v[0], v[1], v[2]};
  s.effects.push_back(std::move(e));
}

}  // namespace parameters

std::optional<ParameterFormat> parameter_format(const std::string& word) {
  if (word == "stillpoint") return ParameterFormat::kStillpoint;
  if (word == "sdf" || word == "gazebo") return ParameterFormat::kSdf;
  if (word == "matlab") return ParameterFormat::kMatlab;
  if (word == "kalibr") return ParameterFormat::kKalibr;
  if (word == "px4") return ParameterFormat::kPx4;
  if (word == "sensor") return ParameterFormat::kSensor;
  if (word == "imu_calib") return ParameterFormat::kImuCalib;
  return std::nullopt;
}

std::optional<ParameterFormat> guess_format(const std::string& name, const std::string& text) {
  if (name.ends_with(".json")) return ParameterFormat::kMatlab;
  if (text.find("<imu") != std::string::npos) return ParameterFormat::kSdf;
  if (text.find("TC_A") != std::string::npos || text.find("TC_G") != std::string::npos) return ParameterFormat::kPx4;
  if (text.find("_noise_density") != std::string::npos) return ParameterFormat::kKalibr;
  if (text.starts_with("sensor:") || text.find("\nsensor:") != std::string::npos) return ParameterFormat::kSensor;
  if (text.starts_with("SM:") || text.find("\nSM:") != std::string::npos) return ParameterFormat::kImuCalib;
  if (name.ends_with(".yaml") || name.ends_with(".yml")) return ParameterFormat::kStillpoint;
  return std::nullopt;
}

namespace {

Result<ReadParameters> read_foreign(ParameterFormat format, const std::string& text, const std::string& name) {
  switch (format) {
    case ParameterFormat::kSdf:
      return parameters::read_sdf(text, name);
    case ParameterFormat::kMatlab:
      return parameters::read_matlab(text, name);
    case ParameterFormat::kKalibr:
      return parameters::read_kalibr(text, name);
    case ParameterFormat::kPx4:
      return parameters::read_px4(text, name);
    case ParameterFormat::kSensor:
      return parameters::read_sensor(text, name);
    case ParameterFormat::kImuCalib:
      return parameters::read_imu_calib(text, name);
    case ParameterFormat::kStillpoint:
      break;
  }
  auto own = io::parse_simulation(text, name);
  if (!own) return tl::unexpected(own.error());
  return ReadParameters{std::move(*own), {}};
}

}  // namespace

Result<ReadParameters> read_parameters(ParameterFormat format, const std::string& text, const std::string& name) {
  auto read = read_foreign(format, text, name);
  if (!read) return read;
  // The other formats know no ranges: our own reader says whether a sensor can be like that.
  const auto own = io::parse_simulation(io::format_simulation(read->simulation), "as our YAML");
  if (own) return read;
  return fail(ErrorKind::kBadData,
              fmt::format("{}: holds values that no simulated sensor can have; {}", name, own.error().message));
}

WrittenParameters write_parameters(ParameterFormat format, const sim::SimulationConfig& simulation) {
  switch (format) {
    case ParameterFormat::kSdf:
      return parameters::write_sdf(simulation);
    case ParameterFormat::kMatlab:
      return parameters::write_matlab(simulation);
    case ParameterFormat::kKalibr:
      return parameters::write_kalibr(simulation);
    case ParameterFormat::kPx4:
      return parameters::write_px4(simulation);
    case ParameterFormat::kSensor:
      return parameters::write_sensor(simulation);
    case ParameterFormat::kImuCalib:
      return parameters::write_imu_calib(simulation);
    case ParameterFormat::kStillpoint:
      break;
  }
  return {io::format_simulation(simulation), {}};
}

}  // namespace stillpoint::exchange

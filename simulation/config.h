/// What a simulation YAML says (docs/formats.md): the baseline u = H (y - B) with white noise, and a list of effects
/// beyond it.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/types.h"

namespace stillpoint::sim {

/// One triad as configured. noise_sd is the standard deviation of one sample, per axis, in the unit of the reading.
struct TriadConfig {
  Vec3 bias = Vec3::Zero();
  Mat3 matrix = Mat3::Identity();
  double noise_sd = 0.0;
};

/// One entry of `effects:`. Parameters keep the names and units of the catalogue, numbers flattened row-major.
struct EffectConfig {
  std::string id;
  std::map<std::string, std::vector<double>> parameters;
  std::vector<int> axes;                              ///< 0, 1, 2; empty: all
  std::optional<std::pair<double, double>> window_s;  ///< from the start of the recording; none: all the time
};

struct SimulationConfig {
  double rate_hz = 100.0;
  double gravity_mps2 = 9.80665;
  Vec3 field_world_uT{0.0, 20.0, -43.0};  ///< ENU
  std::optional<TriadConfig> accelerometer, gyroscope, magnetometer;
  std::vector<EffectConfig> effects;
};

}  // namespace stillpoint::sim

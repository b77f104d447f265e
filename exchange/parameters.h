/// Parameters of a sensor, simulated or calibrated, in the formats of other programs: read into ours, written from
/// ours, each time with a list of what the other side cannot hold.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "simulation/config.h"

namespace stillpoint::exchange {

enum class ParameterFormat {
  kStillpoint,  ///< the simulation YAML of docs/formats.md
  kSdf,         ///< <imu> of the Simulation Description Format (Gazebo)
  kMatlab,      ///< JSON of imuSensor's loadparams
  kKalibr,      ///< imu.yaml
  kPx4,         ///< thermal parameters TC_A0_..., TC_G0_... as QGroundControl saves them
  kSensor,      ///< `sensor:` of the daemon's configuration, as `stillpoint calibrate --output` writes it
  kImuCalib     ///< YAML of the ROS package imu_calib: the accelerometer alone
};

/// "stillpoint", "sdf" or "gazebo", "matlab", "kalibr", "px4", "sensor", "imu_calib"; nullopt for another word.
[[nodiscard]] std::optional<ParameterFormat> parameter_format(const std::string& word);
/// By what a file of this name and text is.
[[nodiscard]] std::optional<ParameterFormat> guess_format(const std::string& name, const std::string& text);

struct ReadParameters {
  sim::SimulationConfig simulation;
  std::vector<std::string> lost;  ///< what the file says and ours does not hold
};
struct WrittenParameters {
  std::string text;
  std::vector<std::string> lost;  ///< what ours says and the format does not hold
};

/// Fails (65, 78) with the file's name and what is wrong.
[[nodiscard]] Result<ReadParameters> read_parameters(ParameterFormat format, const std::string& text,
                                                     const std::string& name);
[[nodiscard]] WrittenParameters write_parameters(ParameterFormat format, const sim::SimulationConfig& simulation);

}  // namespace stillpoint::exchange

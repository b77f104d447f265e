/// The parts of `stillpoint calibrate`.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib_online/offline/points_fit.h"

namespace stillpoint::app {

/// All give the exit code; `json` is JsonOption::file().
int calibrate_points(const std::string& points, const std::string& method, const calib::PointsOptions& options,
                     const std::string& json);
struct RecordingOptions {
  std::string state, config, output, report, sensor_id;
  std::vector<std::string> turns, rates;  ///< of known angle, as in known_turns.h
  std::optional<double> gravity_mps2, latitude_deg;
};
struct MountOptions {
  std::vector<std::string> recordings, faces{"+z", "+x"};
  std::string output;
  double pose_sd_deg = 1.0;
  std::optional<double> latitude_deg;
};
int calibrate_mount(const MountOptions& options, const std::string& json);
int calibrate_recording(const std::string& recording, const std::string& json, const RecordingOptions& options);

}  // namespace stillpoint::app

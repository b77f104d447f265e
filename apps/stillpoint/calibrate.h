/// The two halves of `stillpoint calibrate`.
#pragma once
#include <string>

#include "calib_online/points_fit.h"

namespace stillpoint::app {

/// Both give the exit code; `json` is JsonOption::file().
int calibrate_points(const std::string& points, const std::string& method, const calib::PointsOptions& options,
                     const std::string& json);
int calibrate_recording(const std::string& recording, const std::string& json, const std::string& state);

}  // namespace stillpoint::app

/// The two halves of `stillpoint calibrate`.
#pragma once
#include <optional>
#include <string>

#include "calib_online/points_fit.h"

namespace stillpoint::app {

/// --json: empty, not asked for; "-": standard output, and nothing else there; else a file.
using JsonTarget = std::optional<std::string>;

int calibrate_points(const std::string& points, const std::string& method, const calib::PointsOptions& options,
                     const JsonTarget& json);
int calibrate_recording(const std::string& recording, const JsonTarget& json, const std::string& state);

}  // namespace stillpoint::app

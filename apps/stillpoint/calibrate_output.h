/// What was learnt as the `sensor:` of the daemon's configuration.
#pragma once
#include <string>

#include "core/calibration.h"

namespace stillpoint::app {

[[nodiscard]] std::string sensor_yaml(const std::string& sensor_id, const CalibrationSnapshot& learnt, bool has_mag);

}  // namespace stillpoint::app

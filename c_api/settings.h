/// The settings of one sensor by their names in the daemon's configuration, without YAML: for the C interface and for
/// Python. The names, ranges and meanings are those of the parts' field lists.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "calib_online/online_calibrator.h"
#include "pipeline/stages.h"

namespace stillpoint::c_api {

struct Settings {
  pipeline::StagesParams stages;
  calib::OnlineCalibratorParams calibrator;
  double stale_after_s = 1.0;
};

/// "attitude.use_magnetometer" and the like, all of them.
[[nodiscard]] std::vector<std::string> setting_names();

/// Empty, or why this setting cannot have this value; then nothing is changed. Flags are 0 and 1.
[[nodiscard]] std::string set(Settings& settings, std::string_view name, double value);

/// Empty, or what is wrong with the settings beyond their ranges.
[[nodiscard]] std::string check(const Settings& settings);

}  // namespace stillpoint::c_api

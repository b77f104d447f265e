/// The two faces of `stillpoint status`. Pre of both: diagnostics and calibration are there.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "apps/stillpoint/watch_model.h"

namespace stillpoint::app {

/// At most 24 lines of 100 columns.
[[nodiscard]] std::string status_text(const WatchState& state);
/// Schema stillpoint.status/1; null where there is no value.
[[nodiscard]] nlohmann::json status_json(const WatchState& state);

}  // namespace stillpoint::app

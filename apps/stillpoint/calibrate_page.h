/// `stillpoint calibrate --recording --report`: a calibration as a page, for whoever has to defend its numbers: what is
/// known and what is missing, which directions were seen, what is left over and how the values came about.
#pragma once
#include <string>

#include "apps/stillpoint/calibrate_report.h"

namespace stillpoint::app {

[[nodiscard]] std::string calibration_html(const std::string& recording, const CalibrationRun& run);

}  // namespace stillpoint::app

/// Every quantity of a calibration with how well it is known, from what, and what would have to be done for the rest.
#pragma once
#include <string>
#include <vector>

#include "apps/stillpoint/calibrate_report.h"

namespace stillpoint::app {

struct Quantity {
  std::string name, unit;
  double sd = 0.0;  ///< of it, rms over its numbers; 0: not known
  bool known = false;
  std::uint32_t used = 0, refused = 0;
  std::string evidence;                ///< of what the two count
  std::vector<std::string> missing{};  ///< in words
};

[[nodiscard]] std::vector<Quantity> quantities(const CalibrationRun& run);
/// What would have to be seen for the rest to be known, a line each.
[[nodiscard]] std::vector<std::string> missing(const CalibrationRun& run);

}  // namespace stillpoint::app

/// What sensors, buses and clocks do to a stream, from one time to another. Each fault with what is required of its
/// detection.
#pragma once
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/types.h"

namespace stillpoint::bench {

struct Interval {
  double from_s = 0.0, to_s = 0.0;  ///< from the first row
  [[nodiscard]] bool holds(double t_s) const { return t_s >= from_s && t_s < to_s; }
};

using Rows = std::vector<RawSample>;

struct DrillFault {
  std::string name;
  SamplePart part = kGyr;  ///< the sensor that is to be blamed
  double seen_s = 0.0;     ///< must be seen within this of its start; 0: harmless, must only not be believed
  /// Draws axes, signs and sizes from `random`: each seed is another instance.
  std::function<void(Rows&, const Interval&, std::mt19937&)> apply;
};

/// All that the drill knows, in the order of the report.
[[nodiscard]] std::vector<DrillFault> drill_faults();

}  // namespace stillpoint::bench

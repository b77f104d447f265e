/// The search over all sensors: what one sensor finds alone, and what the clock does to all of them at once.
#pragma once
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

struct SystemEffect {
  Found found;  ///< in the sensor that sees it best
  Sensor lead = kGyr;
  std::vector<Sensor> sensors;
};

struct EngineResult {
  std::array<std::optional<SensorSearch>, kSensors> sensor;
  std::vector<SystemEffect> system;
};

/// Pre: the signals have an orientation. `without`: names that are not in the library this time. `progress` is told the
/// share of the search that is done at most. Where what is found first is seen through a wrong matrix of the
/// simulation, the matrix is set right in `s` and the search begins anew (settled_matrices.h).
[[nodiscard]] EngineResult search_all(Signals& s, const std::vector<std::string>& without = {},
                                      const std::function<void(double)>& progress = {});

}  // namespace stillpoint::diag

/// A field that is disturbed for a while: at rests in the same tilt its strength and its part along gravity are the
/// same whatever the heading, and at one rest nothing may change at all. A door, a chair, a phone laid beside the
/// sensor.
#pragma once
#include <vector>

#include "diagnosis/forensics/forensics.h"
#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {

struct DisturbedField {
  std::vector<Finding> findings;  ///< one an interval
  Forensics masked;               ///< `raw`, with the magnetometer muted in the intervals
};

/// Intervals that begin and end within the recording, together less than a third of it: what lasts is left to the laws.
/// Nothing where a current is recorded, which may be the cause.
[[nodiscard]] DisturbedField find_disturbed_field(const io::Recording& recording,
                                                  const sim::SimulationConfig& simulation, const Forensics& raw,
                                                  const std::vector<RestWindow>& rest);

}  // namespace stillpoint::diag::detail

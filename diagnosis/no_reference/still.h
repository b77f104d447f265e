/// A recording that lies still throughout: offsets against temperature and supply, with a random walk as the rival.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/no_reference/model.h"
#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag::detail {

/// Whether the gyro's readings never leave the neighbourhood of their median, nor gravity turns as they say: no motion
/// at all.
[[nodiscard]] bool lies_still(const io::Recording& recording);

/// Slow turns in these windows, as of a ship: gravity leans as the gyroscope turns. Where it leans alone the
/// accelerometer drifts.
[[nodiscard]] bool sways(const io::Recording& recording, const std::vector<RestWindow>& windows);

/// Gyroscope and accelerometer offsets in one attitude. A law must beat the walk: it is fitted to the increments of the
/// cell means, in which a random walk is white.
[[nodiscard]] Diagnosis diagnose_still(const io::Recording& recording, const sim::SimulationConfig& simulation,
                                       const std::vector<std::string>& without = {});

}  // namespace stillpoint::diag::detail

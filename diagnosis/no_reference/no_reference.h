/// Diagnosis of a recording that has no reference orientation. Gyroscope and magnetometer watch each other and the
/// moments of rest: at rest the true rate is zero, gravity shows the tilt, and the field stands still in the world
/// while the integrated gyro turns it in the body. What remains is explained by the laws of docs/effects.md or by none.
/// The accelerometer is witnessed at rest alone, by the attitude that the gyroscope carries from rest to rest.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/result.h"
#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// Works on recordings with a window of rest; without one the verdict is insufficient data and says so.
/// What the simulation's effects predict is taken out first. `without`: laws that must not be named.
[[nodiscard]] Diagnosis diagnose_without_reference(const io::Recording& recording,
                                                   const sim::SimulationConfig& simulation,
                                                   const std::vector<std::string>& without = {});

}  // namespace stillpoint::diag

/// What the online calibration learns along a recording. It is fed what the daemon would be fed, by the daemon's own
/// code; an offset that it moves after a recorded quantity is physics, which the calibrated readings no longer show. It
/// follows late, so its course shows less than the truth: the hypothesis is passed through a copy of the same
/// calibration, which is linear in the rates at rest, and compared as it comes out.
#pragma once
#include <string>
#include <vector>

#include "io/recording.h"
#include "simulation/config.h"

namespace stillpoint::diag {

/// The gyroscope's offset as the calibration held it after each window of rest, sensor frame.
struct Trajectory {
  std::vector<double> t_s, temp_degC;  ///< of the window's middle, from the start of the recording; 25 where unknown
  std::vector<Vec3> gyr_bias_radps;
  std::vector<Vec3> per_K;  ///< rad/s: how far the offset would have moved if the true one were 1 rad/s/K (T - 25 degC)
  Vec3 sd_radps = Vec3::Zero();  ///< of the offset at the end, as the calibration states it
};

/// Starts from the simulation's numbers. Empty where gyroscope or accelerometer are missing.
[[nodiscard]] Trajectory calibrate_along(const io::Recording& recording, const sim::SimulationConfig& simulation);

/// Sensitivity of an offset that moves after temperature: the true one, not what the calibration has caught up with.
struct Followed {
  Vec3 k = Vec3::Zero(), sd = Vec3::Zero();  ///< rad/s/K
  double gain_nats = 0.0;                    ///< on the increments, in which a random walk is white
};
[[nodiscard]] Followed follow_temperature(const Trajectory& trajectory);

/// One sentence where the offset moved by more than it is known to; none otherwise.
[[nodiscard]] std::vector<std::string> examine(const Trajectory& trajectory, bool temperature_recorded);

}  // namespace stillpoint::diag

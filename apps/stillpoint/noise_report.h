/// What `stillpoint noise` found at rest, and the ways it is told: a table, blocks to paste, a page.
#pragma once
#include <string>
#include <vector>

#include "simulation/allan.h"

namespace stillpoint::app {

struct AxisNoise {
  std::string channel;
  std::vector<sim::AllanPoint> points;
  sim::NoiseTerms terms;
};

struct SensorNoise {
  std::string name;    ///< as in the columns: "acc"
  std::string key;     ///< as in the simulation YAML: "accelerometer"
  std::string unit;    ///< of the reading: "m/s^2"
  std::string suffix;  ///< of the YAML's keys: "mps2"
  double rate_hz = 0.0;
  std::vector<AxisNoise> axes{};

  /// Median over the axes; an axis without the term counts as zero, so that one axis alone does not speak for all.
  [[nodiscard]] double typical(sim::NoiseKind kind) const;
};

[[nodiscard]] std::string noise_table(const std::vector<SensorNoise>& sensors);
/// After github.com/ethz-asl/kalibr, wiki "IMU Noise Model"; where the random walk is not seen, its upper limit.
[[nodiscard]] std::string kalibr_yaml(const std::vector<SensorNoise>& sensors, double rate_hz);
/// Part of a simulation YAML: every term that was seen.
[[nodiscard]] std::string noise_simulation_block(const std::vector<SensorNoise>& sensors, double rate_hz);
/// Terms, log-log curves with their 95 % bounds and the fitted law, one figure a sensor, and the blocks, as a page.
[[nodiscard]] std::string noise_html(const std::string& recording, const std::vector<SensorNoise>& sensors,
                                     double rate_hz, double seconds);

}  // namespace stillpoint::app

/// How much one effect changes a recording, measured by simulating twins that differ by that effect alone.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "simulation/simulator.h"

namespace stillpoint::sim {

/// Over one triad. Without configured noise the readings themselves set no scale and both numbers stay 0.
struct Strength {
  double rms_over_noise = 0.0;  ///< rms of the change in u over the three axes, divided by noise_sd
  double d_prime =
      0.0;  ///< norm of the change over all samples, in noise_sd, after the best change of H and B is taken off
};

struct EffectStrength {
  std::string effect;
  std::array<Strength, 3> sensor;  ///< acc, gyr, mag
};

/// One entry per effect of the configuration. The whitening takes the noise as white with its configured standard
/// deviation; coloured noise, drift and instability are not whitened.
[[nodiscard]] std::vector<EffectStrength> effect_strengths(const SimulationConfig& config,
                                                           const std::shared_ptr<const Motion>& motion,
                                                           std::uint64_t seed, const RecordedEnvironment& recorded);

}  // namespace stillpoint::sim

/// How much one effect changes a recording, measured by simulating twins that differ by that effect alone.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "simulation/simulator.h"

namespace stillpoint::sim {

/// Over the three axes of one triad, in the reading y, where the noise is. Without configured noise there is no scale
/// and both numbers stay 0.
struct Strength {
  /// Rms of the change over the standard deviation of one sample.
  double rms_over_noise = 0.0;
  /// Norm of the change over all samples after it was whitened with the configured noise - white or coloured, bias
  /// instability, random walk - and the best change of H and B was taken off: the d' of the best detector that knows
  /// neither. Effects that are noise themselves do not enter the whitening.
  double d_prime = 0.0;
};

struct EffectStrength {
  std::string effect;
  std::array<Strength, 3> sensor;  ///< acc, gyr, mag
};

/// One entry per effect of the configuration.
[[nodiscard]] std::vector<EffectStrength> effect_strengths(const SimulationConfig& config,
                                                           const std::shared_ptr<const Motion>& motion,
                                                           std::uint64_t seed, const RecordedEnvironment& recorded);

}  // namespace stillpoint::sim

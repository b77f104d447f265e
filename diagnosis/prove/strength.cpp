#include "diagnosis/prove/strength.h"

#include <algorithm>

#include "diagnosis/reference/regression.h"
#include "io/simulated_recording.h"

namespace stillpoint::diag {

double whitened_d_prime(const sim::SimulationConfig& config, const std::shared_ptr<const sim::Motion>& motion,
                        std::uint64_t seed) {
  sim::SimulationConfig without = config;
  without.effects.clear();
  const auto clean = make_signals(io::to_recording(sim::simulate(without, motion, seed)), without, {});
  const auto changed = make_signals(io::to_recording(sim::simulate(config, motion, seed)), without, {});
  if (!clean || !changed || !clean->has_orientation) return 0.0;
  double strongest = 0.0;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!clean->present[k]) continue;
    Target target = make_target(*clean, k);
    const NoiseModel noise(target.layout, fit_profile(target, {}).leftover);
    target.residual = changed->reading[k] - clean->reading[k];
    strongest = std::max(strongest, fit_with(target, {}, noise, {}).whitened.norm());
  }
  return strongest;
}

}  // namespace stillpoint::diag

#include "diagnosis/prove/strength.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/no_reference/model.h"
#include "diagnosis/reference/regression.h"
#include "io/simulated_recording.h"

namespace stillpoint::diag {
namespace {

/// What gyroscope, magnetometer and rests can see of the effect: its size over the deviation with which the model of
/// the self-consistency, everything it does not know fitted beside, can tell that size.
double d_prime_without_reference(const io::Recording& clean, const io::Recording& changed,
                                 const sim::SimulationConfig& config) {
  auto rest = detail::find_rest(clean, config);
  if (rest.empty()) return 0.0;
  const Forensics raw = examine_raw_values(clean, config);
  detail::SelfConsistency model(clean, config, raw, std::move(rest));
  model.settle();
  double square = 0.0;
  for (const Sensor k : {kGyr, kMag}) {
    if (triad(config, k) == nullptr || triad(clean, k).empty()) continue;
    detail::LawColumn effect{k, std::vector<Vec3>(clean.size(), Vec3::Zero())};
    double size = 0.0;
    for (std::size_t i = 0; i < clean.size(); ++i) {
      const Vec3 delta = triad(config, k)->matrix * (triad(changed, k)[i] - triad(clean, k)[i]);
      if (delta.allFinite()) effect.unit[i] = delta, size += delta.squaredNorm();
    }
    if (size > 0) square += 1.0 / model.fit({effect}).sd.cwiseAbs2()[0];
  }
  return std::sqrt(square);
}

}  // namespace

double whitened_d_prime(const sim::SimulationConfig& config, const std::shared_ptr<const sim::Motion>& motion,
                        std::uint64_t seed) {
  sim::SimulationConfig without = config;
  without.effects.clear();
  const io::Recording before = io::to_recording(sim::simulate(without, motion, seed));
  const io::Recording after = io::to_recording(sim::simulate(config, motion, seed));
  if (config.reference.kind == "none") return d_prime_without_reference(before, after, without);
  const auto clean = make_signals(before, without, {});
  const auto changed = make_signals(after, without, {});
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

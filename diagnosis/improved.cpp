#include "diagnosis/improved.h"

#include <algorithm>
#include <array>
#include <optional>

namespace stillpoint::diag {

sim::SimulationConfig improved_by(const Answer& answer, sim::SimulationConfig simulation) {
  std::erase_if(simulation.effects, [&](const sim::EffectConfig& e) {
    return std::find(answer.surplus.begin(), answer.surplus.end(), e.id) != answer.surplus.end();
  });
  simulation.reference.latency_s += answer.reference_latency_s;
  simulation.effects.insert(simulation.effects.end(), answer.effects.begin(), answer.effects.end());
  const std::array<std::optional<sim::TriadConfig>*, 3> triads{&simulation.accelerometer, &simulation.gyroscope,
                                                               &simulation.magnetometer};
  for (std::size_t k = 0; k < triads.size(); ++k)
    if (answer.numbers[k]) *triads[k] = answer.numbers[k];
  return simulation;
}

}  // namespace stillpoint::diag

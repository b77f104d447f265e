#include "diagnosis/discovery/law_entry.h"

#include <cmath>

#include "diagnosis/discovery/law_words.h"
#include "simulation/law_effect.h"

namespace stillpoint::diag {

std::optional<sim::EffectConfig> law_entry(const Found& found, Sensor sensor, const Eigen::VectorXd& values,
                                           const Eigen::VectorXd& sd) {
  constexpr double kSeen = 3.0;  // standard deviations
  if (!found.id.starts_with("unknown:") || found.window.local || found.shape_name == kTrackerShape) return std::nullopt;
  sim::EffectConfig e;
  e.id = std::string(sim::kLawPrefix) + law_text(found.id);
  e.sensors = {static_cast<sim::Sensor>(sensor)};
  const auto tree = sim::tree_of(e);
  if (!tree || (values.size() != 3 && values.size() != 9) || (values.size() == 9 && !tree->vector)) return std::nullopt;
  auto& numbers = e.parameters[values.size() == 9 ? "matrix" : "k"];
  for (Eigen::Index i = 0; i < values.size(); ++i)
    numbers.push_back(std::abs(values[i]) > kSeen * sd[i] ? values[i] : 0.0);
  return e;
}

}  // namespace stillpoint::diag

#include "simulation/active_effect.h"

#include <algorithm>
#include <limits>

#include "core/result.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::sim {

EffectValues::EffectValues(const EffectConfig& config) {
  const EffectInfo* info = find_effect(config.id);
  SP_EXPECTS(info != nullptr);
  std::size_t used = 0;
  for (std::size_t k = 0; k < info->parameters.size(); ++k) {
    const auto& p = info->parameters[k];
    const auto count = static_cast<std::size_t>(p.count);
    SP_EXPECTS(used + count <= numbers_.size() && k < offset_.size());
    offset_[k] = used;
    const auto given = config.parameters.find(p.key);
    SP_EXPECTS(given != config.parameters.end() ? given->second.size() == count : !p.required);
    for (std::size_t i = 0; i < count; ++i)
      numbers_[used++] = given != config.parameters.end() ? given->second[i] : p.fallback;
  }
}

ActiveEffect::ActiveEffect(const EffectConfig& effect, int entry)
    : values(effect), source("effect " + effect.id + (entry > 1 ? " " + std::to_string(entry) : "")) {
  if (!effect.axes.empty()) axes.setZero();
  for (const int axis : effect.axes) axes[axis] = 1.0;
  constexpr double kEver = std::numeric_limits<double>::max();
  std::tie(from_s, to_s) = effect.window_s.value_or(std::pair{-kEver, kEver});
  const std::string& own = find_effect(effect.id)->sensor;
  for (const Sensor s : kSensors) {
    const auto& chosen = effect.sensors;
    const bool acts = own == prefix(s) || own == "sys" || own == "ref";
    sensors[static_cast<std::size_t>(s)] =
        acts && (chosen.empty() || std::find(chosen.begin(), chosen.end(), s) != chosen.end());
  }
}

std::vector<ActiveEffect> active_effects(const std::vector<EffectConfig>& effects, std::string_view id) {
  std::vector<ActiveEffect> out;
  for (const auto& e : effects)
    if (e.id == id) out.emplace_back(e, static_cast<int>(out.size()) + 1);
  return out;
}

}  // namespace stillpoint::sim

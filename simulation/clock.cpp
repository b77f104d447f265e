#include "simulation/clock.h"

#include <algorithm>

#include "simulation/effect_catalogue.h"

namespace stillpoint::sim {

Clock::Clock(const std::vector<EffectConfig>& effects, double rate_hz, std::uint64_t seed)
    : rate_hz_(rate_hz),
      skew_(active_effects(effects, "sys_skew")),
      gap_(active_effects(effects, "sys_gap")),
      offset_(active_effects(effects, "sys_offset")),
      delay_{active_effects(effects, "acc_delay"), active_effects(effects, "gyr_delay"),
             active_effects(effects, "mag_delay")} {
  for (const auto& e : active_effects(effects, "sys_jitter")) jitter_.emplace_back(e, seed);
}

void Clock::start_row(double row_t_s, double temp_degC) noexcept {
  warmth_Ks_ += warmth_K_ * (row_t_s - row_t_s_);
  warmth_K_ = temp_degC - kReferenceTemp_degC;
  row_t_s_ = row_t_s;
  for (auto& j : jitter_) j.shift_s = j.values.scalar(0) * j.random.normal();
}

double Clock::time_s(Sensor sensor, int axis) const noexcept {
  double t = row_t_s_;
  const auto here = [&](const ActiveEffect& e) { return e.active(row_t_s_) && e.covers(sensor, axis); };
  for (const auto& s : skew_)
    if (here(s)) t += 1e-6 * (s.values.scalar(0) * row_t_s_ + s.values.scalar(1) * warmth_Ks_);
  for (const auto& g : gap_)
    if (here(g) && row_t_s_ > g.values.scalar(1)) t += g.values.scalar(0) / rate_hz_;
  for (const auto& o : offset_)
    if (here(o)) t -= o.values.scalar(0);
  for (const auto& j : jitter_)
    if (here(j)) t += j.shift_s;
  double delay_s = 0.0;
  for (const auto& d : delay_[static_cast<std::size_t>(sensor)])
    if (here(d)) delay_s += d.values.scalar(0);
  return t - delay_s;
}

bool Clock::together(Sensor sensor, int axis, int other) const noexcept {
  const auto same = [&](const auto& effects) {
    return std::all_of(effects.begin(), effects.end(),
                       [&](const auto& e) { return e.covers(sensor, axis) == e.covers(sensor, other); });
  };
  return same(skew_) && same(gap_) && same(offset_) && same(jitter_) && same(delay_[static_cast<std::size_t>(sensor)]);
}

}  // namespace stillpoint::sim

#include "simulation/triad.h"

#include <algorithm>
#include <cmath>

#include "core/result.h"

namespace stillpoint::sim {
namespace {

const char* prefix(Sensor sensor) {
  switch (sensor) {
    case Sensor::kAcc:
      return "acc";
    case Sensor::kGyr:
      return "gyr";
    case Sensor::kMag:
      return "mag";
  }
  return "";
}

}  // namespace

ActiveEffect::ActiveEffect(const EffectConfig& effect) : values(effect), axes(axes_mask(effect)) {
  std::tie(from_s, to_s) = window_of(effect);
}

Triad::Triad(Sensor sensor, const SimulationConfig& config, const TriadConfig& triad, std::uint64_t seed)
    : matrix_(triad.matrix),
      inverse_(triad.matrix.inverse()),
      bias_(triad.bias),
      noise_(triad, 1.0 / config.rate_hz, seed, prefix(sensor)),
      place_(laws_for(config.effects, sensor, Stage::kPlace)),
      element_(laws_for(config.effects, sensor, Stage::kElement)) {
  const std::string own = std::string(prefix(sensor)) + "_";
  for (const auto& effect : config.effects)
    if (effect.id.starts_with(own)) add_effect(effect, effect.id.substr(own.size()), 1.0 / config.rate_hz, seed);
}

void Triad::add_effect(const EffectConfig& e, const std::string& kind, double step_s, std::uint64_t seed) {
  const ActiveEffect active(e);
  if (kind == "delay") delay_.push_back(active);
  if (kind == "sat") clip_.push_back(active);
  if (kind == "quant") quantum_.push_back(active);
  if (kind == "deadzone") dead_zone_.push_back(active);
  if (kind == "hold") hold_.push_back(active);
  if (kind == "flip") flip_.push_back(active);
  if (kind == "temp_lag") lag_.emplace_back(e, active.values.scalar(1));
  if (kind == "vre") rectification_.emplace_back(e, active.values.scalar(1));
  if (kind == "lpf") low_pass_.emplace_back(e);
  if (kind == "resonance") resonance_.emplace_back(e);
  if (kind == "drift") drift_.emplace_back(e, step_s, seed);
  if (kind == "instability") instability_.emplace_back(e, step_s, seed);
}

double Triad::delay_s(double t_s) const noexcept {
  double sum = 0.0;
  for (const auto& d : delay_)
    if (d.active(t_s)) sum += d.values.scalar(0);
  return sum;
}

/// The hidden kind of clipping happens at the element, before the filter rounds its corners; the mag's L is never
/// hidden.
Vec3 Triad::clipped(Vec3 y, double t_s, bool before_filter) const noexcept {
  for (const auto& c : clip_) {
    const bool hidden = filters() && c.values.scalar(1) == 1.0;
    if (hidden != before_filter) continue;
    const Vec3 level = c.values.vec3(0);
    for (int i = 0; i < 3; ++i)
      if (c.on(i, t_s)) y[i] = std::clamp(y[i], -level[i], level[i]);
  }
  return y;
}

Vec3 Triad::element(const Vec3& at_place, const Instant& now, double step_s) noexcept {
  Vec3 signal = at_place + sum_of(element_, now);
  if (filters() && !clip_.empty()) signal = matrix_ * (clipped(inverse_ * signal + bias_, now.t_s, true) - bias_);
  for (auto& r : resonance_) signal = r.choose(r.filter.next(signal, step_s), signal, now.t_s);
  for (auto& l : low_pass_) signal = l.choose(l.filter.next(signal, step_s), signal, now.t_s);
  return signal;
}

Vec3 Triad::reading(const Vec3& filtered, const Instant& now, double row_step_s) noexcept {
  const double t = now.t_s;
  Vec3 u = filtered;
  const auto add = [&](const ActiveEffect& effect, const Vec3& delta) {
    if (effect.active(t)) u += effect.axes.cwiseProduct(delta);
  };
  for (auto& l : lag_) add(l, (now.temp_degC - l.temperature.next(now.temp_degC, row_step_s)) * l.values.vec3(0));
  for (auto& r : rectification_) {
    const Vec3 fast = now.force_mps2 - r.mean.next(now.force_mps2, row_step_s);
    add(r, r.values.vec3(0).cwiseProduct(r.power.next(fast.cwiseAbs2(), row_step_s)));
  }
  for (auto& d : drift_) add(d, d.noise.next());
  for (auto& i : instability_) add(i, i.noise.next());
  for (auto& f : flip_) add(f, row_ % 2 == 0 ? f.values.vec3(0) : Vec3(-f.values.vec3(0)));
  return digital(clipped(inverse_ * u + bias_ + noise_.next(), t, false), t);
}

Vec3 Triad::digital(Vec3 y, double t_s) noexcept {
  for (const auto& q : quantum_)
    for (int i = 0; i < 3; ++i)
      if (const double step = q.values.vec3(0)[i]; q.on(i, t_s)) y[i] = step * std::round(y[i] / step);
  for (const auto& d : dead_zone_)
    for (int i = 0; i < 3; ++i)
      if (d.on(i, t_s) && std::abs(y[i]) < d.values.vec3(0)[i]) y[i] = 0.0;
  Vec3 out = y;
  for (const auto& h : hold_) {
    const bool fresh = row_ % static_cast<std::uint64_t>(h.values.scalar(0)) == 0;
    if (fresh || row_ == 0) held_ = y;
    out = h.choose(held_, y, t_s);
  }
  ++row_;
  return out;
}

}  // namespace stillpoint::sim

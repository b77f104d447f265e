#include "simulation/triad.h"

#include <algorithm>
#include <cmath>

#include "simulation/element.h"

namespace stillpoint::sim {

Triad::Triad(Sensor sensor, const SimulationConfig& config, const TriadConfig& triad, std::uint64_t seed)
    : matrix_(triad.matrix),
      inverse_(triad.matrix.inverse()),
      bias_(triad.bias),
      noise_(triad, 1.0 / config.rate_hz, seed, prefix(sensor)) {
  const std::string own = prefix(sensor);
  for (const auto& e : config.effects)
    if (e.id == own + "_sat" && !clips_before_the_filter(e, config.effects)) clip_.emplace_back(e);
  quantum_ = active_effects(config.effects, own + "_quant");
  dead_zone_ = active_effects(config.effects, own + "_deadzone");
  hold_ = active_effects(config.effects, own + "_hold");
  flip_ = active_effects(config.effects, own + "_flip");
  const double step_s = 1.0 / config.rate_hz;
  for (const auto& e : active_effects(config.effects, own + "_drift")) drift_.emplace_back(e, step_s, seed);
  for (const auto& e : active_effects(config.effects, own + "_instability")) instability_.emplace_back(e, step_s, seed);
}

Vec3 Triad::reading(const Vec3& signal, double row_t_s) noexcept {
  Vec3 u = signal;
  const auto add = [&](const ActiveEffect& effect, const Vec3& delta) {
    if (effect.active(row_t_s)) u += effect.axes.cwiseProduct(delta);
  };
  for (auto& d : drift_) add(d, d.noise.next());
  for (auto& i : instability_) add(i, i.noise.next());
  for (auto& f : flip_) add(f, row_ % 2 == 0 ? f.values.vec3(0) : Vec3(-f.values.vec3(0)));
  return digital(inverse_ * u + bias_ + noise_.next(), row_t_s);
}

Vec3 Triad::digital(Vec3 y, double t_s) noexcept {
  for (const auto& c : clip_) y = within_rails(c, y, t_s);
  for (const auto& q : quantum_)
    for (int i = 0; i < 3; ++i)
      if (const double step = q.values.vec3(0)[i]; q.on(i, t_s)) y[i] = step * std::round(y[i] / step);
  for (const auto& d : dead_zone_)
    for (int i = 0; i < 3; ++i)
      if (d.on(i, t_s) && std::abs(y[i]) < d.values.vec3(0)[i]) y[i] = 0.0;
  Vec3 out = y;
  for (const auto& h : hold_) {
    const double n = h.values.scalar(0), row = static_cast<double>(row_);
    if (row_ == 0 || std::floor(row / n) > std::floor((row - 1.0) / n)) held_ = y;
    out = h.choose(held_, y, t_s);
  }
  ++row_;
  return out;
}

}  // namespace stillpoint::sim

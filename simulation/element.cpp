#include "simulation/element.h"

#include <algorithm>
#include <limits>
#include <string>

namespace stillpoint::sim {

bool clips_before_the_filter(const EffectConfig& saturation, const std::vector<EffectConfig>& effects) {
  const auto hidden = saturation.parameters.find("hidden");
  if (hidden == saturation.parameters.end() || hidden->second.front() != 1.0) return false;
  const std::string sensor = saturation.id.substr(0, 4);
  return std::any_of(effects.begin(), effects.end(),
                     [&](const auto& e) { return e.id == sensor + "lpf" || e.id == sensor + "resonance"; });
}

Vec3 within_rails(const ActiveEffect& saturation, Vec3 y, double t_s) noexcept {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Vec3 level = saturation.values.vec3(0), side = saturation.values.vec3(2);
  for (int i = 0; i < 3; ++i)
    if (saturation.on(i, t_s))
      y[i] = std::clamp(y[i], side[i] > 0 ? -kNone : -level[i], side[i] < 0 ? kNone : level[i]);
  return y;
}

Element::Element(Sensor sensor, const SimulationConfig& config, const TriadConfig& triad)
    : matrix_(triad.matrix),
      inverse_(triad.matrix.inverse()),
      bias_(triad.bias),
      place_(laws_for(config.effects, sensor, Stage::kPlace)),
      element_(laws_for(config.effects, sensor, Stage::kElement)),
      written_(law_effects(config.effects, sensor)) {
  const std::string own = std::string(prefix(sensor)) + "_";
  for (const auto& e : config.effects) {
    if (e.id == own + "sat" && clips_before_the_filter(e, config.effects)) clip_.emplace_back(e);
    if (e.id == own + "temp_lag") lag_.emplace_back(e);
    if (e.id == own + "vre") rectification_.emplace_back(e);
    if (e.id == own + "lpf") low_pass_.emplace_back(e);
    if (e.id == own + "resonance") resonance_.emplace_back(e);
  }
}

/// The rail is one of the reading: y = H^-1 u + B and back.
Vec3 Element::clipped(const Vec3& signal, double t_s) const noexcept {
  Vec3 y = inverse_ * signal + bias_;
  for (const auto& c : clip_) y = within_rails(c, y, t_s);
  return matrix_ * (y - bias_);
}

Vec3 Element::signal(const Vec3& at_place, const Instant& now, double step_s) noexcept {
  Vec3 signal = at_place + sum_of(element_, now);
  if (!clip_.empty()) signal = clipped(signal, now.t_s);
  for (auto& r : resonance_) signal = r.choose(r.filter.next(signal, step_s), signal, now.t_s);
  for (auto& l : low_pass_) signal = l.choose(l.filter.next(signal, step_s), signal, now.t_s);
  return signal;
}

bool Element::outside_table() const noexcept {
  return std::any_of(written_.begin(), written_.end(), [](const LawEffect& w) { return w.outside(); });
}

Vec3 Element::output(const Vec3& signal, const Instant& now, double row_step_s,
                     const laws::DriverAt& drivers) noexcept {
  Vec3 u = signal;
  const auto add = [&](const ActiveEffect& effect, const Vec3& delta) {
    if (effect.active(now.t_s)) u += effect.axes.cwiseProduct(delta);
  };
  for (auto& l : lag_) add(l, (now.temp_degC - l.temperature.next(now.temp_degC, row_step_s)) * l.values.vec3(0));
  for (auto& r : rectification_) {
    const Vec3 fast = now.force_mps2 - r.mean.next(now.force_mps2, row_step_s);
    add(r, r.values.vec3(0).cwiseProduct(r.power.next(fast.cwiseAbs2(), row_step_s)));
  }
  for (LawEffect& law : written_) u += law.next(drivers, now.t_s);
  return u;
}

}  // namespace stillpoint::sim

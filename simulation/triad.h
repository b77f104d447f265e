/// One simulated triad from the element to the wire: element laws, filters, y = H^-1 u + B, noise, clipping,
/// quantisation.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "simulation/filters.h"
#include "simulation/laws.h"
#include "simulation/noise.h"

namespace stillpoint::sim {

/// An effect of a triad with its axes, window and numbers, for those that are not laws.
struct ActiveEffect {
  EffectValues values;
  Vec3 axes = Vec3::Ones();
  double from_s = 0.0, to_s = 0.0;

  explicit ActiveEffect(const EffectConfig& effect);
  [[nodiscard]] bool active(double t_s) const noexcept { return t_s >= from_s && t_s <= to_s; }
  [[nodiscard]] bool on(int axis, double t_s) const noexcept { return axes[axis] != 0.0 && active(t_s); }
  /// `changed` on the effect's axes while it is active, else `plain`; no arithmetic, so that repeats stay exact.
  [[nodiscard]] Vec3 choose(const Vec3& changed, const Vec3& plain, double t_s) const noexcept {
    Vec3 out = plain;
    for (int i = 0; i < 3; ++i)
      if (on(i, t_s)) out[i] = changed[i];
    return out;
  }
};

class Triad {
 public:
  Triad(Sensor sensor, const SimulationConfig& config, const TriadConfig& triad, std::uint64_t seed);

  [[nodiscard]] double delay_s(double t_s) const noexcept;
  /// True where the filters must be fed between the samples.
  [[nodiscard]] bool filters() const noexcept { return !low_pass_.empty() || !resonance_.empty(); }
  /// Force, rate or field at the place, with the laws that act there.
  [[nodiscard]] Vec3 at_place(const Vec3& truth, const Instant& now) const noexcept {
    return truth + sum_of(place_, now);
  }
  /// What the element gives, through the filters. Called in time order, `step_s` after the call before.
  Vec3 element(const Vec3& at_place, const Instant& now, double step_s) noexcept;
  /// Reading y from the filtered signal: once per row.
  Vec3 reading(const Vec3& filtered, const Instant& now, double row_step_s) noexcept;
  [[nodiscard]] Vec3 corrected(const Vec3& y) const noexcept { return matrix_ * (y - bias_); }
  [[nodiscard]] const Mat3& inverse() const noexcept { return inverse_; }

 private:
  struct FilteredLaw : ActiveEffect {
    LowPass<double> temperature;
    FilteredLaw(const EffectConfig& e, double tau_s) : ActiveEffect(e), temperature(tau_s) {}
  };
  struct Rectification : ActiveEffect {
    LowPass<Vec3> mean, power;
    Rectification(const EffectConfig& e, double tau_s) : ActiveEffect(e), mean(tau_s), power(tau_s) {}
  };
  struct LowPassEffect : ActiveEffect {
    LowPass<Vec3> filter;
    explicit LowPassEffect(const EffectConfig& e) : ActiveEffect(e), filter(values.scalar(0)) {}
  };
  struct ResonanceEffect : ActiveEffect {
    Resonance filter;
    explicit ResonanceEffect(const EffectConfig& e) : ActiveEffect(e), filter(values.scalar(0), values.scalar(1)) {}
  };
  template <class Noise>
  struct NoiseEffect : ActiveEffect {
    Noise noise;
    NoiseEffect(const EffectConfig& e, double step_s, std::uint64_t seed)
        : ActiveEffect(e), noise(values.vec3(0), step_s, seed, "effect " + e.id) {}
  };

  void add_effect(const EffectConfig& effect, const std::string& kind, double step_s, std::uint64_t seed);
  [[nodiscard]] Vec3 clipped(Vec3 y, double t_s, bool before_filter) const noexcept;
  [[nodiscard]] Vec3 digital(Vec3 y, double t_s) noexcept;

  Mat3 matrix_, inverse_;
  Vec3 bias_;
  TriadNoise noise_;
  std::vector<ActiveLaw> place_, element_;
  std::vector<ActiveEffect> delay_, clip_, quantum_, dead_zone_, hold_, flip_;
  std::vector<FilteredLaw> lag_;
  std::vector<Rectification> rectification_;
  std::vector<LowPassEffect> low_pass_;
  std::vector<ResonanceEffect> resonance_;
  std::vector<NoiseEffect<RandomWalk>> drift_;
  std::vector<NoiseEffect<FlickerNoise>> instability_;
  std::uint64_t row_ = 0;
  Vec3 held_ = Vec3::Zero();
};

}  // namespace stillpoint::sim

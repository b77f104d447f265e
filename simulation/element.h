/// The analogue half of one simulated triad: from force, rate or field at the place through the element's laws to the
/// filtered signal. Its filters remember; axes that look at another time or from another frame have one of their own.
#pragma once
#include <vector>

#include "simulation/filters.h"
#include "simulation/law_effect.h"
#include "simulation/laws.h"

namespace stillpoint::sim {

class Element {
 public:
  Element(Sensor sensor, const SimulationConfig& config, const TriadConfig& triad);

  /// True where the filters must be fed between the samples.
  [[nodiscard]] bool filters() const noexcept { return !low_pass_.empty() || !resonance_.empty(); }
  /// Force, rate or field at the place, with the laws that act there.
  [[nodiscard]] Vec3 at_place(const Vec3& truth, const Instant& now) const noexcept {
    return truth + sum_of(place_, now);
  }
  /// What the element gives, through the filters. Called in time order, `step_s` after the call before.
  Vec3 signal(const Vec3& at_place, const Instant& now, double step_s) noexcept;
  /// That signal with what lags or averages behind it, and with the laws and tables of the file: once per row.
  Vec3 output(const Vec3& signal, const Instant& now, double row_step_s, const laws::DriverAt& drivers) noexcept;
  /// Whether a table was asked outside its range in the last row.
  [[nodiscard]] bool outside_table() const noexcept;

 private:
  struct FilteredLaw : ActiveEffect {
    LowPass<double> temperature;
    explicit FilteredLaw(const EffectConfig& e) : ActiveEffect(e), temperature(values.scalar(1)) {}
  };
  struct Rectification : ActiveEffect {
    LowPass<Vec3> mean, power;
    explicit Rectification(const EffectConfig& e) : ActiveEffect(e), mean(values.scalar(1)), power(values.scalar(1)) {}
  };
  struct LowPassEffect : ActiveEffect {
    LowPass<Vec3> filter;
    explicit LowPassEffect(const EffectConfig& e) : ActiveEffect(e), filter(values.scalar(0)) {}
  };
  struct ResonanceEffect : ActiveEffect {
    Resonance filter;
    explicit ResonanceEffect(const EffectConfig& e) : ActiveEffect(e), filter(values.scalar(0), values.scalar(1)) {}
  };

  [[nodiscard]] Vec3 clipped(const Vec3& signal, double t_s) const noexcept;

  Mat3 matrix_, inverse_;
  Vec3 bias_;
  std::vector<ActiveLaw> place_, element_;
  std::vector<ActiveEffect> clip_;
  std::vector<FilteredLaw> lag_;
  std::vector<Rectification> rectification_;
  std::vector<LowPassEffect> low_pass_;
  std::vector<ResonanceEffect> resonance_;
  std::vector<LawEffect> written_;
};

/// A reading within the rails that it meets: of both signs, or of that of its `side`.
[[nodiscard]] Vec3 within_rails(const ActiveEffect& saturation, Vec3 y, double t_s) noexcept;

/// Saturation that hides behind a filter: `hidden: 1` in a sensor that has one.
[[nodiscard]] bool clips_before_the_filter(const EffectConfig& saturation, const std::vector<EffectConfig>& effects);

}  // namespace stillpoint::sim

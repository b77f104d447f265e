/// The time at which each axis of each sensor looks at the motion. The rows of a recording carry the times of a perfect
/// clock; delays of a sensor, of one of its axes, and faults of the clock move what the reading is of.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "simulation/active_effect.h"
#include "simulation/random.h"

namespace stillpoint::sim {

class Clock {
 public:
  Clock(const std::vector<EffectConfig>& effects, double rate_hz, std::uint64_t seed);

  /// Draws what is random in this row; once per row, in order. Its temperature drives the clock's rate to the next.
  void start_row(double row_t_s, double temp_degC) noexcept;
  /// Time of the motion that this axis reads in the row started last.
  [[nodiscard]] double time_s(Sensor sensor, int axis) const noexcept;
  /// Whether two axes always look at the same time.
  [[nodiscard]] bool together(Sensor sensor, int axis, int other) const noexcept;

 private:
  struct Jitter : ActiveEffect {
    Stream random;
    double shift_s = 0.0;  ///< of this row
    Jitter(const ActiveEffect& e, std::uint64_t seed) : ActiveEffect(e), random(seed, source) {}
  };

  double rate_hz_, row_t_s_ = 0.0;
  double warmth_K_ = 0.0, warmth_Ks_ = 0.0;  ///< above T0, and its integral
  std::vector<ActiveEffect> skew_, gap_, offset_;
  std::array<std::vector<ActiveEffect>, 3> delay_;
  std::vector<Jitter> jitter_;
};

}  // namespace stillpoint::sim

/// The digital half of one simulated triad: from the analogue signal to the wire. Drift and instability, y = H^-1 u +
/// B, noise, clipping, quantisation, dead zone, stale hold.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "simulation/active_effect.h"
#include "simulation/noise.h"

namespace stillpoint::sim {

class Triad {
 public:
  Triad(Sensor sensor, const SimulationConfig& config, const TriadConfig& triad, std::uint64_t seed);

  /// Reading y of the signal u: once per row.
  Vec3 reading(const Vec3& signal, double row_t_s) noexcept;
  [[nodiscard]] Vec3 corrected(const Vec3& y) const noexcept { return matrix_ * (y - bias_); }
  [[nodiscard]] const Mat3& inverse() const noexcept { return inverse_; }

 private:
  template <class Noise>
  struct NoiseEffect : ActiveEffect {
    Noise noise;
    NoiseEffect(const ActiveEffect& e, double step_s, std::uint64_t seed)
        : ActiveEffect(e), noise(values.vec3(0), step_s, seed, source) {}
  };

  [[nodiscard]] Vec3 digital(Vec3 y, double t_s) noexcept;

  Mat3 matrix_, inverse_;
  Vec3 bias_;
  TriadNoise noise_;
  std::vector<ActiveEffect> clip_, quantum_, dead_zone_, hold_, flip_;
  std::vector<NoiseEffect<RandomWalk>> drift_;
  std::vector<NoiseEffect<FlickerNoise>> instability_;
  std::uint64_t row_ = 0;
  Vec3 held_ = Vec3::Zero();
};

}  // namespace stillpoint::sim

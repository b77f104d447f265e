/// The input of the benchmarks that need no recording: a hand that rests for five seconds and moves for five, with
/// consumer-grade noise, so that rest windows and calibration are at work.
#pragma once
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/types.h"
#include "core/units.h"

namespace stillpoint::bench {

inline std::vector<RawSample> hand_samples(std::size_t count, double rate_hz, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<RawSample> out(count);
  const Array3 gravity{0.0, 0.0, kStandardGravity_mps2}, field{0.0, 20.0, -43.0};
  for (std::size_t i = 0; i < count; ++i) {
    const double t_s = static_cast<double>(i) / rate_hz;
    const double moving = std::fmod(t_s, 10.0) < 5.0 ? 0.0 : 1.0;
    RawSample& s = out[i];
    s.t_ns = std::llround(kNsPerSecond * t_s);
    s.sequence = i;
    s.has = kAcc | kGyr | kMag | kTemp;
    s.temp_degC = 25.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double turn = std::sin(2.0 * std::numbers::pi * t_s / 5.0 + static_cast<double>(k));
      s.gyr_radps[k] = moving * turn + 0.002 * normal(random);
      s.acc_mps2[k] = gravity[k] + moving * std::cos(5.0 * t_s) + 0.02 * normal(random);
      s.mag_uT[k] = field[k] + 0.4 * normal(random);
    }
  }
  return out;
}

}  // namespace stillpoint::bench

/// Undone in the sensor's own reading, a resonance is partly the noise that it is to explain.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/reference/plausible.h"
#include "diagnosis/reference/response.h"

namespace stillpoint::diag {
namespace {

constexpr double kResonance_Hz = 7.0, kBand_Hz = 5.0, kNoise = 0.006;

/// What a resonance says of this signal: -x'' / (2 pi f_n)^2 of what the band leaves of it.
Series3 undone(const Series3& x, const RowTimes& rows) {
  const Response low = low_pass(kBand_Hz);
  return apply_response(x, rows, [low](double f) { return low(f) * std::pow(f / kResonance_Hz, 2); });
}

TEST(OwnNoise, MakesAResonanceOfItsSizeAndNoLargerOne) {
  Signals s;
  s.n = 20'000, s.dt_s = 0.01;
  s.noise_sd[kAcc] = kNoise, s.band_hz[kAcc] = kBand_Hz;
  RowTimes rows;
  rows.step_s = s.dt_s;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, kNoise);
  Series3 noise(s.n, 3), motion(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    noise.row(i) << normal(random), normal(random), normal(random);
    motion.row(i).setConstant(std::sin(2.0 * M_PI * 1.0 * s.dt_s * static_cast<double>(i)));
  }
  SensorSearch search;
  search.sensor = kAcc;
  Found law;
  law.timing = Eigen::Vector2d(kResonance_Hz, 0.05);
  law.offset = undone(noise, rows);
  EXPECT_TRUE(is_its_own_noise(s, search, law));
  const double shared = noise.cwiseProduct(law.offset).sum();
  law.offset *= std::sqrt(3.0 * shared / law.offset.squaredNorm());  // three times what the noise shares with it
  EXPECT_TRUE(is_its_own_noise(s, search, law));
  law.offset *= std::sqrt(2.0);  // six times
  EXPECT_FALSE(is_its_own_noise(s, search, law));
  law.offset = undone(motion, rows);
  EXPECT_FALSE(is_its_own_noise(s, search, law));
}

}  // namespace
}  // namespace stillpoint::diag

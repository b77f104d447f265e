/// A sensor that has become noisier, told from a body that shakes it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "pipeline/noise_watch.h"

namespace stillpoint::pipeline {
namespace {

constexpr double kNoise = 0.03, kFault_s = 40.0;

/// A hand that swings the sensor to and fro; `spoil` changes what it reads from kFault_s on.
class Swing {
 public:
  using Spoil = std::function<void(Array3& reading, double t_s, Swing& swing)>;
  Swing(double rate_hz, unsigned seed) : step_s_(1.0 / rate_hz), random_(seed) {}

  double noise() { return normal_(random_); }

  /// Time from the fault until the watch speaks; infinite where it never does.
  double told_s(double until_s, const Spoil& spoil) {
    for (; t_s_ < until_s; t_s_ += step_s_) {
      const double phase = 2.0 * std::numbers::pi * 0.8 * t_s_;
      Array3 reading{4.0 * std::sin(phase), 3.0 * std::cos(1.7 * phase), 9.8 + 2.0 * std::sin(2.3 * phase)};
      for (double& x : reading) x += kNoise * noise();
      if (t_s_ > kFault_s) spoil(reading, t_s_, *this);
      watch_.note(reading, step_s_, true);
      if (watch_.excess() > 1.0) return t_s_ - kFault_s;
    }
    return std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] bool speaks() const { return watch_.excess() > 1.0; }

 private:
  double t_s_ = 0.0, step_s_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  NoiseWatch watch_{0.05};
};

TEST(NoiseWatch, TellsANoiseTenTimesAsLarge) {
  for (const double rate_hz : {50.0, 100.0, 400.0, 1000.0})
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const double told_s = Swing(rate_hz, seed).told_s(60.0, [](Array3& r, double, Swing& s) {
        for (double& x : r) x += 10.0 * kNoise * s.noise();
      });
      EXPECT_GT(told_s, 0.0) << rate_hz << ' ' << seed;
      EXPECT_LT(told_s, 6.0) << rate_hz << ' ' << seed;
    }
}

TEST(NoiseWatch, TellsANoiseOnOneAxis) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const double told_s =
        Swing(100.0, seed).told_s(60.0, [](Array3& r, double, Swing& s) { r[1] += 10.0 * kNoise * s.noise(); });
    EXPECT_LT(told_s, 4.0) << seed;
  }
}

TEST(NoiseWatch, SaysNothingOfASoundSensorNorOfAWilderMotion) {
  const auto sound = [](Array3&, double, Swing&) {};
  const auto wilder = [](Array3& r, double t_s, Swing&) {
    for (double& x : r) x *= 1.0 + std::sin(2.0 * std::numbers::pi * 3.0 * t_s);
  };
  // Twice a second something hits the body, and it rings for a twentieth of a second.
  const auto blows = [](Array3& r, double t_s, Swing& s) {
    for (double& x : r) x += 30.0 * std::exp(-std::fmod(t_s, 0.5) / 0.05) * s.noise();
  };
  // A motor of 23 turns a second.
  const auto hums = [](Array3& r, double t_s, Swing&) { r[2] += 3.0 * std::sin(2.0 * std::numbers::pi * 23.0 * t_s); };
  for (const auto& spoil : {Swing::Spoil(sound), Swing::Spoil(wilder), Swing::Spoil(blows), Swing::Spoil(hums)})
    for (unsigned seed = 1; seed <= 20; ++seed)
      EXPECT_EQ(Swing(100.0, seed).told_s(300.0, spoil), std::numeric_limits<double>::infinity()) << seed;
}

TEST(NoiseWatch, GetsUsedToANoiseThatStays) {
  Swing swing(100.0, 1);
  const auto noisy = [](Array3& r, double, Swing& s) {
    for (double& x : r) x += 10.0 * kNoise * s.noise();
  };
  ASSERT_LT(swing.told_s(60.0, noisy), 10.0);
  while (swing.told_s(400.0, noisy) < 400.0) continue;
  EXPECT_FALSE(swing.speaks());
}

TEST(NoiseWatch, KnowsNothingBeforeTheBodyHasMoved) {
  NoiseWatch watch(0.05);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 10'000; ++k) {
    const double sd = k < 6'000 ? kNoise : 1.0;  // a minute of rest, then motors run
    watch.note({sd * normal(random), sd * normal(random), sd * normal(random)}, 0.01, k > 6'000);
    ASSERT_LE(watch.excess(), 1.0) << k;
  }
}

}  // namespace
}  // namespace stillpoint::pipeline

/// Rests that the gyroscope denies: gravity tells whether it is the gyroscope that is wrong.
#include "fusion/denied_rest.h"

#include <random>

#include "core/so3.h"
#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

constexpr double kPeriod_s = 0.05;

/// Periods until it is decided, at most 60; the filter's world turns by `false_rate`, gravity in truth by `true_rate`.
int decided_after(const Vec3& false_rate, const Vec3& true_rate, double noise_mps2, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0.0, noise_mps2);
  DeniedRest d;
  for (int i = 1; i <= 60; ++i) {
    const double t = i * kPeriod_s;
    const Vec3 force = exp_so3(Vec3(t * (false_rate - true_rate))) * Vec3(0.2, -0.1, kStandardGravity_mps2);
    d.note(force + Vec3(noise(engine), noise(engine), noise(engine)), false_rate, kPeriod_s);
    if (d.denies_gyroscope()) return i;
  }
  return 61;
}

TEST(DeniedRest, FalseRatesAreSeenWithinASecond) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
    EXPECT_LT(decided_after(Vec3(0.01, 0.015, 0.01), Vec3::Zero(), 0.01, seed), 20) << seed;
}

TEST(DeniedRest, TrueTurnsAndTurnsAboutTheVerticalAreNone) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    EXPECT_EQ(decided_after(Vec3(0.01, 0.015, 0.01), Vec3(0.01, 0.015, 0.01), 0.02, seed), 61) << seed;
    EXPECT_EQ(decided_after(Vec3(0, 0, 0.03), Vec3::Zero(), 0.02, seed), 61) << seed;
  }
}

TEST(DeniedRest, AnOffsetThatJumpedIsLearntInOneShortRest) {
  test::RandomMotion motion({.gyr_bias_walk_radps_rtHz = 0.0}, 5);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 1000; ++i) e = filter.step(motion.next(true), true);
  const Vec3 before = vec(e.gyro_bias_radps);
  const Vec3 jump(0.015, -0.01, 0.01);
  for (int i = 0; i < 220; ++i) {
    CalibratedSample s = motion.next(true);
    vec(s.gyr_radps) += jump;
    e = filter.step(s, true);
  }
  EXPECT_LT((vec(e.gyro_bias_radps) - before - jump).norm(), 2e-3) << "2.2 s after it";
  EXPECT_GT(e.sigma_yaw_rad, 0.01) << "what it turned the heading by since the last rest is not known";
}

}  // namespace
}  // namespace stillpoint::fusion

/// What a recording without a reference shows at rest and between few rests: laws of the accelerometer, lines, rails
/// beneath the noise, a body that only seems to lie still.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/finding_effect.h"
#include "diagnosis/no_reference/no_reference.h"
#include "diagnosis/no_reference/noisy_rail.h"
#include "diagnosis/no_reference/still.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

const std::string kPoses = "{kind: rest_poses, poses: 16, duration_s: 80, min_rest_s: 2.5, max_rest_s: 3.5}";
const std::string kHand = "{kind: hand, duration_s: 60}";
/// Switched on in rest, and in the hand from then on.
const std::string kOneRest = "{kind: hand, duration_s: 50, min_bout_s: 60, max_bout_s: 60, min_rest_s: 4}";

io::Recording recorded(const sim::SimulationConfig& config, std::uint64_t seed) {
  return test::record(config, "", {}, seed);
}

TEST(FewRests, OneIsEnoughForGyroscopeAgainstField) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    EXPECT_EQ(
        diagnose_without_reference(recorded(test::without_reference(kOneRest), seed), test::without_reference(kOneRest))
            .verdict,
        Verdict::kNoMismatch);
    const auto truth = test::without_reference(kOneRest, "[{effect: mag_delay, tau_s: 0.012}]");
    const auto d = diagnose_without_reference(recorded(truth, seed), test::without_reference(kOneRest));
    const Finding* f = test::finding(d, "mag_delay");
    ASSERT_NE(f, nullptr) << d.summary;
    EXPECT_EQ(d.findings.size(), 1U);
    EXPECT_NEAR(test::parameter(*f, "tau").value, 0.012, 0.001);
  }
}

TEST(AtRest, TheGyroscopeWitnessesTheAccelerometer) {
  const auto truth = test::without_reference(kPoses, "[{effect: acc_temp_scale, S_per_K: [3e-4, -2e-4, 3e-4]}]");
  const auto d = diagnose_without_reference(recorded(truth, 4), test::without_reference(kPoses));
  const Finding* f = test::finding(d, "acc_temp_scale");
  ASSERT_NE(f, nullptr) << d.summary;
  EXPECT_NEAR(test::parameter(*f, "S_x").value, 3e-4, 5e-5);
  EXPECT_NEAR(test::parameter(*f, "S_y").value, -2e-4, 5e-5);
}

TEST(AtRest, AStepOfTheFieldIsFoundToTheRow) {
  const auto truth =
      test::without_reference(kHand, "[{effect: mag_field_step, b_world_uT: [9, -6, 10], t0_s: 23.457}]");
  io::Recording r = recorded(truth, 5);
  for (std::int64_t& t : r.t_ns) t += 1'000'000'000'000;  // a clock that was not set to zero
  const auto d = diagnose_without_reference(r, test::without_reference(kHand));
  ASSERT_EQ(d.findings.size(), 1U) << d.summary;
  EXPECT_EQ(d.findings[0].effect, "mag_field_step");
  EXPECT_EQ(d.verdict, Verdict::kExplained) << d.summary;
  EXPECT_NEAR(test::parameter(d.findings[0], "t0").value, 23.457, 0.011);  // as in a simulation, which begins at zero
  EXPECT_NEAR(d.findings[0].interval_s[0], 1023.457, 0.011);
  EXPECT_EQ(diagnose_without_reference(r, truth).verdict, Verdict::kNoMismatch);
}

/// Of 60 Hz at 100 rows a second 40 are read.
TEST(LinesAtRest, AreNamedWithFrequencySizeAndPhase) {
  const auto truth =
      test::without_reference(kHand, "[{effect: gyr_alias, b_radps: [0.004, 0, -0.002], f_hz: 60, phase_rad: 0.7}]");
  const auto r = recorded(truth, 6);
  const auto d = diagnose_without_reference(r, test::without_reference(kHand));
  ASSERT_EQ(d.findings.size(), 1U) << d.summary;
  ASSERT_EQ(d.findings[0].effect, "gyr_alias");
  EXPECT_NEAR(test::parameter(d.findings[0], "f").value, 40.0, 0.01);
  // As an entry of the simulation it makes the same readings.
  auto improved = test::without_reference(kHand);
  improved.effects.push_back(effect_of(d.findings[0]).value());
  EXPECT_EQ(diagnose_without_reference(r, improved).verdict, Verdict::kNoMismatch);
  const auto added = [](const sim::SimulationConfig& config) {
    return Vec3(recorded(config, 9).gyr_radps[1234] - recorded(test::without_reference(kHand), 9).gyr_radps[1234]);
  };
  EXPECT_LT((added(improved) - added(truth)).norm(), 0.0005);
}

TEST(LinesAtRest, AFlipOfPolarityIsNoLine) {
  const auto truth = test::without_reference(kHand, "[{effect: mag_flip, b_uT: [0.5, 0.3, -0.4]}]");
  const auto d = diagnose_without_reference(recorded(truth, 7), test::without_reference(kHand));
  ASSERT_EQ(d.findings.size(), 1U) << d.summary;
  EXPECT_EQ(d.findings[0].effect, "mag_flip");
}

TEST(LinesAtRest, WhatShakesTheBodyIsToldAndNotNamed) {
  const auto truth = test::without_reference(kHand,
                                             "[{effect: gyr_alias, b_radps: [0.004, 0, 0], f_hz: 17}, "
                                             "{effect: acc_alias, b_mps2: [0, 0.05, 0], f_hz: 17}]");
  const auto d = diagnose_without_reference(recorded(truth, 8), test::without_reference(kHand));
  EXPECT_TRUE(d.findings.empty()) << d.summary;
  EXPECT_TRUE(std::any_of(d.notices.begin(), d.notices.end(),
                          [](const std::string& n) { return n.find("shakes the body") != std::string::npos; }));
}

/// The element clips, and noise is added after it.
io::Recording clipped(double level_radps) {
  io::Recording r = recorded(test::without_reference(kHand), 9);
  std::mt19937_64 engine(1);
  std::normal_distribution<double> noise(0.0, 0.0005);
  for (Vec3& w : r.gyr_radps)
    for (int k = 0; k < 3; ++k)
      if (std::abs(w[k]) > level_radps) w[k] = std::copysign(level_radps, w[k]) + noise(engine);
  return r;
}

TEST(NoisyRail, IsNamedWhereTurnsAreCutOff) {
  const auto d = diagnose_without_reference(clipped(1.2), test::without_reference(kHand));
  const Finding* f = test::finding(d, "gyr_sat");
  ASSERT_NE(f, nullptr) << d.summary;
  EXPECT_EQ(d.verdict, Verdict::kPartlyExplained);
  for (const Parameter& p : f->parameters) EXPECT_NEAR(std::abs(p.value), 1.2, 0.001) << p.name;
}

/// A turntable stands at one rate as a rail does, but nothing is missing.
TEST(NoisyRail, IsNoSteadyRate) {
  const auto config = test::without_reference("{kind: turntable, duration_s: 60}");
  const auto r = recorded(config, 9);
  EXPECT_EQ(test::finding(diagnose_without_reference(r, config), "gyr_sat"), nullptr);
}

/// A swell: 1 degree in 8 s, read by gyroscope and accelerometer.
TEST(Still, AShipIsNot) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> normal;
  for (const double sway_rad : {0.0, 0.017, 0.1}) {
    io::Recording r;
    for (int i = 0; i < 6000; ++i) {
      const double t = 0.01 * i, w = 2.0 * M_PI / 8.0, roll = sway_rad * std::sin(w * t);
      r.t_ns.push_back(static_cast<std::int64_t>(std::llround(1e9 * t)));
      r.gyr_radps.emplace_back(sway_rad * w * std::cos(w * t) + 5e-4 * normal(engine), 5e-4 * normal(engine),
                               5e-4 * normal(engine));
      r.acc_mps2.emplace_back(0.01 * normal(engine), 9.81 * std::sin(roll) + 0.01 * normal(engine),
                              9.81 * std::cos(roll) + 0.01 * normal(engine));
    }
    EXPECT_EQ(detail::lies_still(r), sway_rad == 0.0) << sway_rad;
  }
}

}  // namespace
}  // namespace stillpoint::diag

/// Lines beyond the band in which bodies move: seen in the readings, where a camera's noise or the mean of neighbouring
/// rows would hide them.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kTurn = 2.0 * std::numbers::pi;

Vec3 swing(double t_s, double frequency_Hz, const Vec3& size) { return size * std::sin(kTurn * frequency_Hz * t_s); }

sim::SimulationConfig sampled_at(const std::string& reference, double rate_hz, double duration_s) {
  auto config = test::baseline(reference, duration_s);
  config.rate_hz = rate_hz;
  return config;
}

TEST(LinesInReadings, OfTheSizeOfTheNoiseBesideACamera) {
  const auto config = test::baseline("mocap", 60.0);
  io::Recording r = test::record(config, "", {}, 21);
  const Vec3 size(0.02, -0.01, 0.015);  // a camera's second derivative errs by 1 m/s^2
  for (std::size_t i = 0; i < r.size(); ++i) r.acc_mps2[i] += swing(r.t_s(i), 22.37, size);
  const Answer answer = diagnose(r, config);
  const Finding* line = test::finding(answer, "acc_alias");
  ASSERT_NE(line, nullptr) << answer.diagnosis.summary;
  EXPECT_THAT(line->equivalent, Contains("ref_error"));
  ASSERT_EQ(line->parameters.size(), 4U);
  EXPECT_NEAR(line->parameters[3].value, 22.37, 0.003);
  const double sign = line->parameters[0].value > 0 ? 1.0 : -1.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(sign * line->parameters[axis].value, size[static_cast<Eigen::Index>(axis)], 0.0025);
  EXPECT_GT(line->held_out.removable_share_removed, 0.9);
}

TEST(LinesInReadings, WhatTwoSensorsSwingAtIsTheBodys) {
  const auto config = test::baseline("mocap", 60.0);
  io::Recording r = test::record(config, "", {}, 22);
  for (std::size_t i = 0; i < r.size(); ++i) {
    r.acc_mps2[i] += swing(r.t_s(i), 22.37, {0.06, -0.03, 0.05});
    r.gyr_radps[i] += swing(r.t_s(i), 22.37, {0.004, 0.002, 0.002});
  }
  EXPECT_THAT(test::names(diagnose(r, config)), Not(Contains(HasSubstr("alias"))));
}

/// As an engine does with its speed, or idling: no line of electronics.
TEST(LinesInReadings, WhatSwellsAndFadesIsTheBodys) {
  const auto config = sampled_at("mocap", 100, 60.0);
  for (const bool idles : {false, true}) {
    io::Recording r = test::record(config, "", {}, 27);
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double t_s = r.t_s(i), driving = 0.5 * (std::tanh(t_s - 20.0) - std::tanh(t_s - 45.0));
      const double size = idles ? 0.25 + 0.75 * driving : 1.0 + 0.35 * std::sin(0.8 * t_s);
      r.acc_mps2[i] += size * swing(t_s, 22.37, {0.2, -0.1, 0.15});
    }
    const Answer answer = diagnose(r, config);
    EXPECT_THAT(test::names(answer), Not(Contains(HasSubstr("alias")))) << idles;
    if (idles) continue;  // in two pieces no law of one size is worth telling
    EXPECT_THAT(answer.diagnosis.notices, Contains(HasSubstr("acc: swings at 22.37 Hz, more and less")));
  }
}

/// The accelerometer feels them up to half the rate, the gyroscope hardly.
TEST(LinesInReadings, TheHarmonicsOfASteadyStepAreNone) {
  auto config = test::baseline("mocap", 60.0);
  config.motion->kind = "walking";
  config.accelerometer->noise_sd = 0.006;
  EXPECT_THAT(test::names(diagnose(test::record(config, "", {}, 26), config)), IsEmpty());
}

TEST(LinesInReadings, WhatTheSimulationHasIsNotToldAgain) {
  auto config = test::baseline("mocap", 60.0);
  config.effects.push_back({.id = "acc_alias",
                            .parameters = {{"b_mps2", {0.02, -0.01, 0.015}}, {"f_hz", {22.37}}, {"phase_rad", {0.4}}},
                            .axes = {},
                            .window_s = {}});
  EXPECT_THAT(test::names(diagnose(test::record(config, "", {}, 23), config)), Each(Not(HasSubstr("alias"))));
}

/// The mean of the two rows of a frame knows nothing of a flip.
TEST(LinesInReadings, AFlipFromRowToRowBesideHalfAsManyFrames) {
  const auto config = sampled_at("mocap", 100, 60.0);
  io::Recording r = test::record(config, "", {}, 24);
  for (std::size_t i = 0; i < r.size(); ++i) {
    r.mag_uT[i] += (i % 2 == 0 ? 1.0 : -1.0) * Vec3(0.2, 0.4, -0.3);
    if (i % 2 == 0) continue;
    r.ref_q_world_body[i].setConstant(io::kMissing), r.ref_position_m[i].setConstant(io::kMissing);
  }
  const Answer answer = diagnose(r, config);
  const Finding* flip = test::finding(answer, "mag_flip");
  ASSERT_NE(flip, nullptr) << answer.diagnosis.summary;
  EXPECT_NEAR(flip->parameters[1].value, 0.4, 0.02);
  EXPECT_TRUE(answer.diagnosis.noise.empty()) << "it is no noise";
}

/// 36 000 rows are searched as means of two.
TEST(LinesInReadings, BeyondHalfTheRateOfMergedRowsItKeepsItsFrequency) {
  const auto config = sampled_at("exact", 400, 90.0);
  io::Recording r = test::record(config, "", {}, 25);
  for (std::size_t i = 0; i < r.size(); ++i) r.gyr_radps[i] += swing(r.t_s(i), 161.3, {0.0005, 0.0003, -0.0004});
  const Answer answer = diagnose(r, config);
  const Finding* line = test::finding(answer, "gyr_alias");
  ASSERT_NE(line, nullptr) << answer.diagnosis.summary;
  EXPECT_NEAR(line->parameters[3].value, 161.3, 0.01);
  EXPECT_NEAR(std::abs(line->parameters[0].value), 0.0005, 0.00005);
}

}  // namespace
}  // namespace stillpoint::diag

/// Physics that the simulation has and the sensor has not is named, and not in the improved simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosis/improved.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

const test::Parameters kSurplusThermal{{"k_radps_per_K", {8e-4, -5e-4, 6e-4}}};
const test::Parameters kSurplusArm{{"r_m", {0.1, -0.05, 0.08}}};

sim::SimulationConfig with(sim::SimulationConfig config, const std::string& id, const test::Parameters& parameters) {
  config.effects.push_back({.id = id, .parameters = parameters, .axes = {}, .window_s = {}});
  return config;
}

class SurplusPhysics : public testing::TestWithParam<const char*> {};

TEST_P(SurplusPhysics, AnEffectThatTheSensorHasNotIsNamedAndTakenOut) {
  const auto truth = test::baseline(GetParam());
  const io::Recording recording = test::record(truth, "", {}, 3);
  const auto simulation = with(with(truth, "gyr_temp_lin", kSurplusThermal), "acc_lever", kSurplusArm);
  const Answer answer = diagnose(recording, simulation);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kSurplusPhysics) << answer.diagnosis.summary;
  EXPECT_TRUE(test::names(answer).empty());
  ASSERT_EQ(answer.diagnosis.surplus.size(), 2U);
  for (const Surplus& s : answer.diagnosis.surplus) EXPECT_NEAR(s.in_recording, 0.0, 0.1) << s.effect;
  EXPECT_TRUE(improved_by(answer, simulation).effects.empty());
}

TEST_P(SurplusPhysics, AnEffectOfHalfTheSizeIsSurplusAndFoundAgain) {
  const auto truth = test::baseline(GetParam());
  const io::Recording recording = test::record(truth, "acc_lever", {{"r_m", {0.05, -0.025, 0.04}}}, 4);
  const auto simulation = with(truth, "acc_lever", kSurplusArm);
  const Answer answer = diagnose(recording, simulation);
  ASSERT_EQ(answer.diagnosis.surplus.size(), 1U);
  EXPECT_NEAR(answer.diagnosis.surplus[0].in_recording, 0.5, 0.05);
  EXPECT_EQ(test::names(answer), std::vector<std::string>{"acc_lever"});
  const auto improved = improved_by(answer, simulation);
  ASSERT_EQ(improved.effects.size(), 1U);
  EXPECT_NEAR(improved.effects[0].parameters.at("r_m")[0], 0.05, 0.005);
}

TEST_P(SurplusPhysics, WhatTheRecordingHoldsStays) {
  const auto truth = test::baseline(GetParam());
  const io::Recording recording = test::record(truth, "gyr_temp_lin", kSurplusThermal, 5);
  const Answer answer = diagnose(recording, with(truth, "gyr_temp_lin", kSurplusThermal));
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kNoMismatch) << answer.diagnosis.summary;
  EXPECT_TRUE(answer.diagnosis.surplus.empty());
}

TEST_P(SurplusPhysics, ACopiedRandomWalkIsNamedAndARealOneIsNot) {
  for (const bool real : {false, true}) {
    const auto still = test::baseline(GetParam());
    auto walking = still;
    walking.gyroscope->random_walk_per_sqrts = 3e-4;
    const io::Recording recording = test::record(real ? walking : still, "", {}, 6);
    const Answer answer = diagnose(recording, walking);
    EXPECT_TRUE(test::names(answer).empty()) << answer.diagnosis.summary;
    EXPECT_EQ(answer.diagnosis.surplus.size(), real ? 0U : 1U) << answer.diagnosis.summary;
    EXPECT_EQ(improved_by(answer, walking).gyroscope->random_walk_per_sqrts, real ? 3e-4 : 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Reference, SurplusPhysics, testing::Values("exact", "mocap"));

/// The simulation has the drift with the temperature, and the sensor an estimator that takes most of it away.
TEST(Tracker, WhatAnEstimatorOnBoardTakesAwayIsNamedByTheEstimator) {
  auto config = test::baseline("exact", 160.0);
  config.motion->min_rest_s = 6.0, config.motion->max_rest_s = 10.0;
  config.environment.temperature = {.kind = "warm_up", .rise_K = 12.0, .tau_s = 60.0};
  config = with(config, "gyr_temp_lin", {{"k_radps_per_K", {-6e-4, 2e-4, 2e-4}}});
  const io::Recording recording = test::record(config, "sys_tracker", {{"tau_s", {10.0}}}, 3);
  const Answer answer = diagnose(recording, config);
  const Finding* tracker = test::finding(answer, "sys_tracker");
  ASSERT_NE(tracker, nullptr) << answer.diagnosis.summary;
  EXPECT_NEAR(test::parameter(*tracker, "tau").value, 10.0, 2.0);
  EXPECT_THAT(answer.diagnosis.surplus, testing::IsEmpty());
  EXPECT_EQ(test::finding(diagnose(recording, improved_by(answer, config)), "sys_tracker"), nullptr) << "told again";
}

}  // namespace
}  // namespace stillpoint::diag

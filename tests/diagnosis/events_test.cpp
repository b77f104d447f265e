/// What begins at a moment and settles: a shock, a switch, a part that moved.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simulation/law_effect.h"
#include "simulation/simulator.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

Answer answer_of(sim::SimulationConfig truth, std::uint64_t seed = 3) {
  const io::Recording recording = io::to_recording(sim::simulate(truth, seed));
  truth.effects.clear();
  return diagnose(recording, truth);
}

/// A jump that settles looks to an autoregression like its own memory, but for the one row in which it jumps.
TEST(Events, AnOffsetThatJumpsAndSettlesIsALawOfItsMoment) {
  const Answer answer = answer_of(test::with_law(
      "  - {effect: law, sensor: gyr, law: \"step(t, 26.07) * exp(-(t - 26.07) / 3)\", k: [0.007, -0.004, 0.005]}",
      "0.0002"));
  ASSERT_THAT(answer.effects, testing::Contains(testing::Truly(sim::is_law))) << answer.diagnosis.summary;
  const auto law = std::find_if(answer.effects.begin(), answer.effects.end(), sim::is_law);
  EXPECT_THAT(sim::expression_of(*law), testing::MatchesRegex("step\\(t, 26.0[678]\\) \\* exp\\(.*"))
      << answer.diagnosis.summary;
}

/// A temperature that moves with the body passes for anything in a window, most of all behind an estimator on board.
TEST(Events, WhatJumpsAndSettlesBesideACameraIsNoTemperatureForAWhile) {
  for (const std::uint64_t seed : {2, 6}) {
    sim::SimulationConfig truth = test::parsed(
        "rate_hz: 50\naccelerometer: {noise_mps2: 0.004}\ngyroscope: {noise_radps: 0.0002}\n"
        "magnetometer: {noise_uT: 0.1}\nmotion: {kind: hand, duration_s: 60}\n"
        "environment: {temperature: {kind: activity}}\n"
        "reference: {kind: mocap, orientation_sd_rad: 0.0008, position_sd_m: 0.0002, band_hz: 4.3}\neffects:\n"
        "  - {effect: law, sensor: gyr, law: \"step(t, 21.71) * exp(-(t - 21.71) / 2.45)\", k: [0.0076, -0.0043, "
        "-0.0053]}");
    EXPECT_THAT(test::names(answer_of(truth, seed)),
                testing::ElementsAre(testing::MatchesRegex("unknown:step\\(t, 21\\.[567].*\\) \\* exp\\(.*")))
        << seed;
  }
}

/// Between two states of a current every level is the same one, wherever the shares of its values lie.
TEST(Events, WhatACurrentSwitchesOnIsFoundBetweenItsStates) {
  const Answer answer = answer_of(
      test::with_law("  - {effect: law, sensor: mag, law: \"m * step(I, 0.9)\", k: [0.012, -0.01, 0.02]}"), 4);
  EXPECT_THAT(test::names(answer), testing::ElementsAre(testing::StartsWith("unknown:m * step(I, ")))
      << answer.diagnosis.summary;
}

/// An offset that is there to the end has no driver but its moment, and a simulation can have it.
TEST(Events, AnOffsetThatStaysIsTheLawOfAStep) {
  const Answer answer = answer_of(
      test::parsed("rate_hz: 100\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
                   "magnetometer: {noise_uT: 0.3}\nmotion: {kind: hand, duration_s: 60}\n"
                   "environment: {temperature: {kind: constant}, current: {kind: off}}\n"
                   "effects: [{effect: law, sensor: gyr, law: \"step(t, 33.01)\", k: [0.004, -0.003, 0.002]}]"));
  ASSERT_THAT(test::names(answer), testing::ElementsAre(testing::MatchesRegex("unknown:step\\(t, 33.0[0-9]*\\)")))
      << answer.diagnosis.summary;
  ASSERT_EQ(answer.effects.size(), 1U);
  EXPECT_TRUE(sim::is_law(answer.effects.front()));
  EXPECT_NEAR(answer.effects.front().parameters.at("k")[0], 0.004, 2e-4);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kExplained) << answer.diagnosis.summary;
}

/// Stress that relaxes after a part was bolted down: with its time constant, so that a simulation can have it.
TEST(Events, WhatRelaxesFromTheStartOnIsWrittenAsALaw) {
  const Answer answer = answer_of(
      test::with_law("  - {effect: law, sensor: acc, law: \"log(1 + t / 5)\", k: [0.02, -0.015, 0.03]}", "0.0002"));
  ASSERT_THAT(answer.effects, testing::Contains(testing::Truly(sim::is_law))) << answer.diagnosis.summary;
  const auto law = std::find_if(answer.effects.begin(), answer.effects.end(), sim::is_law);
  EXPECT_THAT(sim::expression_of(*law), testing::StartsWith("log(1 + t / ")) << answer.diagnosis.summary;
}

}  // namespace
}  // namespace stillpoint::diag

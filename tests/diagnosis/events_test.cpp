/// What begins at a moment and settles: a shock, a switch, a part that moved.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simulation/law_effect.h"
#include "simulation/simulator.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

Answer answer_of(sim::SimulationConfig truth) {
  const io::Recording recording = io::to_recording(sim::simulate(truth, 3));
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

/// Whether a law outside the catalogue is told: beside names and in their place, however weak it is, and not of what is
/// clean or known already.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "diagnosis/discovery/discover.h"
#include "diagnosis/prove/invented.h"
#include "diagnosis/reference/judge.h"
#include "diagnosis/reference/refine.h"
#include "simulation/law_effect.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::with_law;

TEST(Discovery, ACleanRecordingGivesNoLaw) {
  const sim::SimulationConfig clean = with_law("  []");
  for (const auto& e : diagnose(test::record(clean, "", {}, 4), clean).effects) EXPECT_FALSE(sim::is_law(e)) << e.id;
}

/// A temperature that has risen within seconds is a constant from then on, and beside a camera that is a wrong bias.
TEST(Discovery, WhatIsNearlyAConstantBesideACameraIsNoLaw) {
  sim::SimulationConfig config = with_law("  - {effect: law, sensor: gyr, law: \"d(T)\", k: [-0.02, -0.001, -0.013]}");
  config.rate_hz = 100;
  config.motion->kind = "boat";
  config.motion->duration_s = 40;
  config.reference.kind = "mocap";
  config.environment.temperature.kind = "activity";
  config.environment.temperature.rise_K = 30;
  config.environment.temperature.tau_s = 2;
  const io::Recording recording = test::record(config, "", {}, 3);
  config.effects.clear();
  const Answer answer = diagnose(recording, config);
  ASSERT_EQ(answer.effects.size(), 1U) << answer.diagnosis.summary;
  EXPECT_EQ(sim::expression_of(answer.effects.front()), "d(T)");
}

/// Its largest swing looks like a delay of all sensors that comes and goes.
TEST(Discovery, ALatencyThatSwingsIsALawAndNoDelayForAWhile) {
  sim::SimulationConfig config = with_law(
      "  - {effect: law, sensor: gyr, law: \"d(w) * (1 + sin(t / 4.8))\", k: [0.0025, 0.0025, 0.0025]}\n"
      "  - {effect: law, sensor: acc, law: \"d(f) * (1 + sin(t / 4.8))\", k: [0.0025, 0.0025, 0.0025]}\n"
      "  - {effect: law, sensor: mag, law: \"d(m) * (1 + sin(t / 4.8))\", k: [0.0025, 0.0025, 0.0025]}");
  config.reference.kind = "mocap";
  const io::Recording recording = test::record(config, "", {}, 3);
  config.effects.clear();
  const auto said = test::names(diagnose(recording, config));
  for (const char* vector : {"w", "f", "m"})
    EXPECT_THAT(said, testing::Contains(testing::StartsWith(fmt::format("unknown:d({}) * sin(t / 4.", vector))));
  EXPECT_THAT(said, testing::Not(testing::Contains(testing::EndsWith("_delay"))));
}

/// Too weak to be spoken of by what it gains, which the noise model has half of; it predicts all the same.
TEST(Discovery, AWeakLawIsToldThatSurelyPredicts) {
  sim::SimulationConfig config =
      with_law("  - {effect: law, sensor: gyr, law: \"lag(I, 3)\", k: [0.0003, 0.0002, -0.0003]}");
  const io::Recording recording = test::record(config, "", {}, 3);
  config.effects.clear();
  const Answer answer = diagnose(recording, config);
  ASSERT_FALSE(answer.diagnosis.findings.empty());
  EXPECT_THAT(answer.diagnosis.findings[0].effect, testing::StartsWith("unknown:lag(I, "));
}

/// A name that explains a third of what a law does, although neither would be looked for where nothing was named.
TEST(Discovery, ALawThatExplainsClearlyMoreTakesThePlaceOfAName) {
  sim::SimulationConfig config = with_law("  - {effect: law, sensor: gyr, law: \"lag(w_y, 0.6)\", k: [0, -0.0005, 0]}");
  const io::Recording recording = test::record(config, "", {}, 3);
  config.effects.clear();
  Result<Signals> s = make_signals(recording, config, {});
  ASSERT_TRUE(s);
  EngineResult engine;
  SensorSearch& gyr = engine.sensor[kGyr].emplace(start_search(*s, kGyr, {}));
  const auto is_gsens = [](const Law& law) { return law.id == "gyr_gsens"; };
  const Law& name = *std::find_if(gyr.laws.begin(), gyr.laws.end(), is_gsens);
  Found found = found_from(name, Candidate{}, name.columns(0.0));
  Judge(gyr).weigh(found);
  gyr.found.push_back(std::move(found));
  discover(*s, engine);
  ASSERT_EQ(gyr.found.size(), 1U);
  EXPECT_THAT(gyr.found[0].id, testing::StartsWith("unknown:lag(w_y, 0.")) << gyr.found[0].gain_nats;
}

TEST(Discovery, ALawThatLeavesOnlyNoiseExplains) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"norm(w) * I\", k: [0.002, 0.001, -0.002]}");
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  const io::Recording recording = test::record(truth, "", {}, 3);
  const Answer answer = diagnose(recording, plain);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kExplained) << answer.diagnosis.summary;
  sim::SimulationConfig improved = plain;
  improved.effects = answer.effects;
  const Diagnosis again = diagnose(recording, improved).diagnosis;
  EXPECT_EQ(again.verdict, Verdict::kNoMismatch) << again.summary;
}

TEST(Discovery, ALawThatTheSimulationHasIsNotFoundAgain) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"lag(w_y * w_z, 0.5)\", k: [0.01, 0, -0.02]}");
  const Answer answer = diagnose(test::record(truth, "", {}, 3), truth);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kNoMismatch) << answer.diagnosis.summary;
}

/// A supply that falls with the current goes along with the law, and is not its cause.
TEST(Discovery, NoNumberIsFittedBesideANameThatIsNotTheCause) {
  const InventedCase c = invent("cold-spring-51", 16, true);  // acc: the current times the square of a column
  sim::SimulationConfig given = c.baseline;
  given.motion.reset();
  given.environment = {};
  given.reference = {};
  const Diagnosis d = diagnose(c.recording, given).diagnosis;
  ASSERT_THAT(test::names(d), testing::Not(testing::Contains("acc_volt")));
  const Diagnosis without = diagnose(c.recording, given, {"acc_volt"}).diagnosis;
  ASSERT_EQ(d.findings.front().effect, "unknown:I * motor_rpm^2");
  ASSERT_EQ(without.findings.front().effect, d.findings.front().effect);
  for (std::size_t i = 0; i < 3; ++i) {
    const Parameter &here = d.findings.front().parameters[i], &there = without.findings.front().parameters[i];
    EXPECT_NEAR(here.value, there.value, 1e-3 * std::abs(there.value));
    EXPECT_NEAR(here.ci95[1] - here.ci95[0], there.ci95[1] - there.ci95[0], 1e-3 * (there.ci95[1] - there.ci95[0]));
  }
}

}  // namespace
}  // namespace stillpoint::diag

/// Late beside a camera by less than time stamps are good for: the camera's, unless the reference cannot be late.
#include <gmock/gmock.h>

#include "diagnosis/improved.h"
#include "io/simulation_yaml.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

io::Recording beside_a_camera_late_by(double latency_s) {
  auto config = test::beside_a_good_camera();
  config.reference.latency_s = latency_s;
  return test::record(config, "", {}, 9);
}

TEST(ReferenceLatency, IsInTheImprovedSimulationAsTheReferences) {
  const auto config = test::beside_a_good_camera();
  const io::Recording recording = beside_a_camera_late_by(4e-4);
  const Answer answer = diagnose(recording, config);
  EXPECT_THAT(test::names(answer), testing::ElementsAre("sys_offset")) << answer.diagnosis.summary;
  const sim::SimulationConfig improved = improved_by(answer, config);
  EXPECT_TRUE(improved.effects.empty());
  EXPECT_NEAR(improved.reference.latency_s, 4e-4, 2e-5);
  EXPECT_THAT(test::names(diagnose(recording, improved)), testing::IsEmpty());
}

TEST(ReferenceLatency, OfLessThanAnyRigIsGoodForIsNoMismatch) {
  const auto config = test::beside_a_good_camera();
  const io::Recording recording = beside_a_camera_late_by(8e-5);
  const Answer answer = diagnose(recording, config);
  EXPECT_THAT(test::names(answer), testing::IsEmpty()) << answer.diagnosis.summary;
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kNoMismatch);
  EXPECT_THAT(answer.diagnosis.notices, testing::Contains(testing::HasSubstr("reference: late by 0.0")));
  EXPECT_NEAR(answer.reference_latency_s, 8e-5, 2e-5);
}

TEST(ReferenceLatency, AnExactReferenceHasNone) {
  auto config = test::beside_a_good_camera();
  config.reference.kind = "exact";
  const Answer answer = diagnose(test::record(config, "sys_offset", {{"tau_s", {4e-4}}}, 9), config);
  EXPECT_EQ(answer.reference_latency_s, 0.0);
  ASSERT_EQ(improved_by(answer, config).effects.size(), 1U);
  EXPECT_NEAR(improved_by(answer, config).effects[0].parameters.at("tau_s")[0], 4e-4, 1e-5);
}

/// A reference of whose errors the simulation says nothing is not held to be exact because its latency is known.
TEST(ReferenceLatency, IsWrittenWithoutAWordOfTheErrors) {
  auto config = test::parsed("rate_hz: 50\ngyroscope: {noise_radps: 0.001}\n");
  config.reference.latency_s = 4e-4;
  const auto again = test::parsed(io::format_simulation(config));
  EXPECT_EQ(again.reference.latency_s, 4e-4);
  EXPECT_FALSE(again.reference.stated);
  config.reference.kind = "mocap";  // by a program: that is written, and is a word
  EXPECT_EQ(test::parsed(io::format_simulation(config)).reference.kind, "mocap");
  EXPECT_EQ(test::parsed(io::format_simulation(config)).reference.latency_s, 4e-4);
  EXPECT_TRUE(
      test::parsed("rate_hz: 50\ngyroscope: {noise_radps: 0.001}\nreference: {kind: exact}\n").reference.stated);
}

}  // namespace
}  // namespace stillpoint::diag

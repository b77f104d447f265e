/// Effects whose driver is not in the recording: no recorded quantity is blamed for them, and a law that is there keeps
/// its name.
#include <gmock/gmock.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::names;
using test::Parameters;

sim::SimulationConfig loaded() {
  auto config = test::baseline("mocap", 60.0);
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  config.environment.current.kind = "steps";
  return config;
}

io::Recording without_supply(const std::string& id, const Parameters& parameters, std::uint64_t seed) {
  io::Recording r = test::record(loaded(), id, parameters, seed);
  r.supply_V.clear();
  r.current_A.clear();
  return r;
}

const auto kNothingBlamed = testing::Each(testing::AnyOf(testing::StartsWith("unknown:"), testing::EndsWith("_drift")));

/// Six rests in a minute: a matrix times the force, and a lag behind the warm-up, fit what the supply does there.
TEST(Unrecorded, TheSupplyThatNobodyRecordedIsNotBlamedOnForceOrTemperature) {
  for (const std::uint64_t seed : {101, 108, 114, 119, 127, 133, 134, 137})
    EXPECT_THAT(
        names(diagnose(without_supply("gyr_volt", {{"k_radps_per_V", {0.010, -0.006, 0.008}}}, seed), loaded())),
        kNothingBlamed)
        << seed;
}

TEST(Unrecorded, ACurveBesideAStepOfNoKnownCauseIsNotCalledThermal) {
  for (const std::uint64_t seed : {119, 124})
    EXPECT_THAT(names(diagnose(without_supply("acc_volt", {{"k_mps2_per_V", {0.3, -0.2, 0.25}}}, seed), loaded())),
                kNothingBlamed)
        << seed;
}

TEST(Unrecorded, WhatMovesAlongOneLineIsUnknownWithTheColumnToRecord) {
  const Answer answer =
      diagnose(without_supply("gyr_volt", {{"k_radps_per_V", {0.010, -0.006, 0.008}}}, 119), loaded());
  ASSERT_THAT(names(answer), testing::Contains("unknown:u(t)"));
  const auto& findings = answer.diagnosis.findings;
  const auto f =
      std::find_if(findings.begin(), findings.end(), [](const Finding& x) { return x.effect == "unknown:u(t)"; });
  EXPECT_THAT(f->driver, testing::HasSubstr("supply_V"));
  EXPECT_THAT(f->decided_by, testing::HasSubstr("supply_V"));
}

/// Nine numbers that do not lie on one line are no scalar's doing.
TEST(Unrecorded, AMatrixOfTheForceKeepsItsNameWithoutTheSupply) {
  const Parameters matrix{{"G_radps_per_mps2", {2e-4, 1e-4, -2e-4, 1e-4, -2e-4, 2e-4, -1e-4, 2e-4, 1e-4}}};
  for (const std::uint64_t seed : {11, 12})
    EXPECT_THAT(names(diagnose(without_supply("gyr_gsens", matrix, seed), loaded())), testing::ElementsAre("gyr_gsens"))
        << seed;
}

}  // namespace
}  // namespace stillpoint::diag

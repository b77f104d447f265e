/// Laws that are seen through a matrix of the simulation that is wrong, and laws that were found before the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosis/forensics/forensics.h"
#include "simulated.h"

namespace stillpoint::diag::test {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

Mat3 bare(double size) {
  Mat3 m;
  m << 0.6, -0.9, 0.5, 1.0, -0.5, -0.8, -0.4, 0.9, 0.7;
  return Mat3::Identity() + size * m;
}

/// What parts that nobody has calibrated read, and the simulation of ideal ones.
io::Recording uncalibrated(const std::vector<sim::EffectConfig>& effects, std::uint64_t seed) {
  auto truth = baseline("exact", 60.0);
  truth.rate_hz = 100;
  truth.accelerometer->matrix = bare(0.03), truth.gyroscope->matrix = bare(-0.03),
  truth.magnetometer->matrix = bare(0.05);
  truth.effects = effects;
  return io::to_recording(sim::simulate(truth, seed));
}

sim::EffectConfig entry(const std::string& id, const Parameters& parameters) {
  return {.id = id, .parameters = parameters, .axes = {}, .window_s = {}};
}

Answer against_ideal(const io::Recording& recording) {
  auto ideal = baseline("exact", 60.0);
  ideal.rate_hz = 100;
  return diagnose(recording, ideal);
}

double number(const Finding& f, const std::string& name) {
  for (const Parameter& p : f.parameters)
    if (p.name == name) return p.value;
  ADD_FAILURE() << f.effect << " has no " << name;
  return 0.0;
}

TEST(SettledMatrices, ALatenessIsOneLawBehindWrongMatrices) {
  const Answer answer = against_ideal(uncalibrated({entry("sys_offset", {{"tau_s", {0.024}}})}, 1));
  ASSERT_THAT(names(answer), ElementsAre("sys_offset"));
  EXPECT_NEAR(number(answer.diagnosis.findings[0], "tau"), 0.024, 1e-4);
  ASSERT_TRUE(answer.numbers[kMag]);
  EXPECT_LT((answer.numbers[kMag]->matrix - bare(0.05)).norm(), 2e-3);
}

TEST(SettledMatrices, ALeverIsOneLawBehindWrongMatrices) {
  const Answer answer = against_ideal(uncalibrated({entry("acc_lever", {{"r_m", {0.3, -0.2, 0.25}}})}, 2));
  ASSERT_THAT(names(answer), ElementsAre("acc_lever"));
  EXPECT_NEAR(number(answer.diagnosis.findings[0], "r_x"), 0.3, 1e-3);
  EXPECT_NEAR(number(answer.diagnosis.findings[0], "r_y"), -0.2, 1e-3);
}

TEST(SettledMatrices, TheResidualTellsOfTheSimulationAsItWasGiven) {
  const io::Recording recording = uncalibrated({entry("sys_offset", {{"tau_s", {0.024}}})}, 3);
  auto ideal = baseline("exact", 60.0);
  ideal.rate_hz = 100;
  auto told = ideal;
  told.magnetometer->matrix = bare(0.05);
  const auto before = [&](const sim::SimulationConfig& c) {
    for (const ChannelResidual& r : diagnose(recording, c).diagnosis.residual)
      if (r.channel == "mag_x") return r.rms_before;
    return 0.0;
  };
  EXPECT_GT(before(ideal), 1.3 * before(told));
}

TEST(SettledMatrices, ALatenessBesideALeverIsOfAllSensors) {
  const Answer answer = against_ideal(
      uncalibrated({entry("sys_offset", {{"tau_s", {0.004}}}), entry("acc_lever", {{"r_m", {0.3, -0.2, 0.25}}})}, 4));
  EXPECT_THAT(names(answer), UnorderedElementsAre("sys_offset", "acc_lever"));
}

/// The line is found first, beside an error as large as itself; where its frequency stayed as it was then, products of
/// it with the temperature made up for it.
TEST(ShapesAgain, ALineIsSharpenedBesideWhatWasFoundAfterIt) {
  auto truth = with_law(
      "  - {effect: mag_line, b_uT: [1, -0.8, 0.6], f_hz: 10.886, phase_rad: 4.9}\n"
      "  - {effect: mag_hard_step, b_uT: [0.6, -0.5, 0.4], t0_s: 31}\n");
  auto given = truth;
  given.effects.clear();
  const Answer answer = diagnose(io::to_recording(sim::simulate(truth, 5)), given);
  ASSERT_THAT(names(answer), UnorderedElementsAre("mag_line", "mag_hard_step"));
  for (const Finding& f : answer.diagnosis.findings)
    if (f.effect == "mag_line")
      for (const Parameter& p : f.parameters)
        if (p.name == "f") {
          EXPECT_GT(10.886, p.ci95[0]) << p.value;
          EXPECT_LT(10.886, p.ci95[1]) << p.value;
        }
}

/// Along the axis of a turntable a lever does nothing: whatever number it had there, the improved simulation would
/// take it to other motions.
TEST(Untold, TheLeverAlongATurntablesAxisStaysSmall) {
  auto truth = with_law("  - {effect: acc_lever, r_m: [0.05, -0.03, 0.02]}\n");
  truth.motion->kind = "turntable";
  auto given = truth;
  given.effects.clear();
  const Answer answer = diagnose(io::to_recording(sim::simulate(truth, 6)), given);
  ASSERT_THAT(names(answer), testing::Contains("acc_lever"));
  const Finding& f = *std::find_if(answer.diagnosis.findings.begin(), answer.diagnosis.findings.end(),
                                   [](const Finding& x) { return x.effect == "acc_lever"; });
  EXPECT_NEAR(number(f, "r_x"), 0.05, 2e-3);
  EXPECT_NEAR(number(f, "r_y"), -0.03, 2e-3);
  EXPECT_LT(std::abs(number(f, "r_z")), 0.1);
}

}  // namespace
}  // namespace stillpoint::diag::test

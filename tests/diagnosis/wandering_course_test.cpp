/// A slow turn of the reference that the sensors agree about is taken out; what is theirs, or the clock's, is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/apparatus.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

sim::SimulationConfig quiet(const std::string& reference = "mocap", const std::string& effects = " []") {
  return test::parsed(
      "rate_hz: 50\naccelerometer: {noise_mps2: 0.004}\ngyroscope: {noise_radps: 0.0002}\n"
      "magnetometer: {noise_uT: 0.05}\nmotion: {kind: hand, duration_s: 60}\n"
      "environment: {temperature: {kind: warm_up, rise_K: 15}}\n"
      "reference: {kind: " +
      reference + (reference == "mocap" ? ", orientation_sd_rad: 0.0003, position_sd_m: 0.0001, band_hz: 4" : "") +
      "}\neffects:" + effects);
}

Vec3 slowly(double t_s) { return 2e-3 * Vec3(std::sin(0.3 * t_s), std::cos(0.17 * t_s), std::sin(0.45 * t_s + 1.0)); }

Signals wandering_signals_of(const io::Recording& r, const sim::SimulationConfig& config) {
  Result<Signals> s = make_signals(r, config, {});
  EXPECT_TRUE(s);
  return *s;
}

class Wandering : public testing::TestWithParam<bool> {};

TEST_P(Wandering, IsTakenOutOfWhatTheReferencePredicts) {
  const sim::SimulationConfig config = quiet();
  const io::Recording right = test::record(config, "", {}, 5);
  io::Recording wrong = right;
  test::turn_reference(wrong, slowly, GetParam());
  const Signals truth = wandering_signals_of(right, config), before = wandering_signals_of(wrong, config);
  Signals after = before;
  Answer answer;
  take_out_wandering(after, answer);
  ASSERT_TRUE(after.reference_wanders);
  EXPECT_THAT(answer.diagnosis.notices, testing::ElementsAre(testing::HasSubstr("acc and gyr and mag agree")));
  for (const Sensor k : {kAcc, kMag}) {  // a constant turn is a matrix, and is not looked for here
    const auto wandering = [&](const Signals& s) {
      const Series3 off = s.predicted[k] - truth.predicted[k];
      return (off.rowwise() - off.colwise().mean()).norm();
    };
    EXPECT_LT(wandering(after), 0.35 * wandering(before)) << k;
    EXPECT_NEAR((after.residual[k] + after.predicted[k] - before.residual[k] - before.predicted[k]).norm(), 0.0, 1e-6);
  }
  EXPECT_LT((after.residual[kGyr] - truth.residual[kGyr]).norm(),
            0.6 * (before.residual[kGyr] - truth.residual[kGyr]).norm());
}

INSTANTIATE_TEST_SUITE_P(Of, Wandering, testing::Bool(),
                         [](const auto& the) { return the.param ? "ACameraInTheWorld" : "MarkersOnTheBody"; });

TEST(Wandering, IsNothingThatOneSensorSays) {
  for (const char* effects : {"\n  - {effect: acc_temp_lin, k_mps2_per_K: [0.004, -0.003, 0.005]}",
                              "\n  - {effect: gyr_temp_lin, k_radps_per_K: [0.0002, -0.0001, 0.0002]}",
                              "\n  - {effect: mag_temp_lin, k_uT_per_K: [0.05, -0.04, 0.06]}", " []"}) {
    const sim::SimulationConfig config = quiet("mocap", effects);
    Signals s = wandering_signals_of(test::record(config, "", {}, 7), config);
    Answer answer;
    take_out_wandering(s, answer);
    EXPECT_FALSE(s.reference_wanders) << effects;
    EXPECT_TRUE(answer.diagnosis.notices.empty());
  }
}

TEST(Wandering, IsNoLateness) {
  sim::SimulationConfig config = quiet();
  io::Recording r = test::record(config, "sys_offset", {{"tau_s", {0.02}}}, 7);
  const Answer late = diagnose(r, config);
  EXPECT_THAT(test::names(late), testing::ElementsAre("sys_offset"));
  test::turn_reference(r, slowly);
  const Answer both = diagnose(r, config);
  EXPECT_THAT(test::names(both), testing::UnorderedElementsAre("sys_offset", "ref_error"))
      << "it errs by more than the simulation says";
  EXPECT_THAT(both.diagnosis.notices, testing::Contains(testing::HasSubstr("turns slowly against the sensors")));
}

TEST(Wandering, IsNoMountThatGivesWay) {
  const sim::SimulationConfig config = quiet();
  io::Recording r = test::record(config, "", {}, 5);
  test::turn_reference(r, [](double t_s) -> Vec3 {
    return (1.0 - std::exp(-std::max(0.0, t_s - 25.0) / 5.0)) * Vec3(8e-3, 2e-3, -3e-3);
  });
  Signals s = wandering_signals_of(r, config);
  Answer answer;
  take_out_wandering(s, answer);
  EXPECT_FALSE(s.reference_wanders);
}

TEST(Wandering, IsNotLookedForInAnExactReference) {
  const sim::SimulationConfig config = quiet("exact");
  io::Recording r = test::record(config, "", {}, 5);
  test::turn_reference(r, slowly);
  Signals s = wandering_signals_of(r, config);
  s.exact_reference = true;
  Answer answer;
  take_out_wandering(s, answer);
  EXPECT_FALSE(s.reference_wanders);
}

}  // namespace
}  // namespace stillpoint::diag

/// A slow turn of the reference that the sensors agree about is taken out; what is theirs, or the clock's, is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/so3.h"
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

/// Of markers against the body, or of a camera against the world.
void turn_reference(io::Recording& r, bool in_world) {
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double t = r.t_s(i) - r.t_s(0);
    const Quat turn = exp_quat(2e-3 * Vec3(std::sin(0.3 * t), std::cos(0.17 * t), std::sin(0.45 * t + 1.0)));
    const auto& x = r.ref_q_world_body[i];
    const Quat q(x[0], x[1], x[2], x[3]), turned = in_world ? turn * q : q * turn;
    r.ref_q_world_body[i] = Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z());
  }
}

Signals signals_of(const io::Recording& r, const sim::SimulationConfig& config) {
  Result<Signals> s = make_signals(r, config, {});
  EXPECT_TRUE(s);
  return *s;
}

class Wandering : public testing::TestWithParam<bool> {};

TEST_P(Wandering, IsTakenOutOfWhatTheReferencePredicts) {
  const sim::SimulationConfig config = quiet();
  const io::Recording right = test::record(config, "", {}, 5);
  io::Recording wrong = right;
  turn_reference(wrong, GetParam());
  const Signals truth = signals_of(right, config), before = signals_of(wrong, config);
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
    Signals s = signals_of(test::record(config, "", {}, 7), config);
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
  turn_reference(r, false);
  const Answer both = diagnose(r, config);
  EXPECT_THAT(test::names(both), testing::UnorderedElementsAre("sys_offset", "ref_error"))
      << "it errs by more than the simulation says";
  EXPECT_THAT(both.diagnosis.notices, testing::Contains(testing::HasSubstr("turns slowly against the sensors")));
}

TEST(Wandering, IsNoMountThatGivesWay) {
  const sim::SimulationConfig config = quiet();
  io::Recording r = test::record(config, "", {}, 5);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double since_s = std::max(0.0, r.t_s(i) - r.t_s(0) - 25.0);
    const auto& x = r.ref_q_world_body[i];
    const Quat q = Quat(x[0], x[1], x[2], x[3]) * exp_quat((1.0 - std::exp(-since_s / 5.0)) * Vec3(8e-3, 2e-3, -3e-3));
    r.ref_q_world_body[i] = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  }
  Signals s = signals_of(r, config);
  Answer answer;
  take_out_wandering(s, answer);
  EXPECT_FALSE(s.reference_wanders);
}

TEST(Wandering, IsNotLookedForInAnExactReference) {
  const sim::SimulationConfig config = quiet("exact");
  io::Recording r = test::record(config, "", {}, 5);
  turn_reference(r, false);
  Signals s = signals_of(r, config);
  s.exact_reference = true;
  Answer answer;
  take_out_wandering(s, answer);
  EXPECT_FALSE(s.reference_wanders);
}

}  // namespace
}  // namespace stillpoint::diag

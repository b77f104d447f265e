/// The course of the online calibration along a recording: what follows temperature is told from what does not.
#include "diagnosis/trajectory/trajectory.h"

#include <gtest/gtest.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

sim::SimulationConfig warming() {
  sim::SimulationConfig s = test::baseline("none", 240.0);
  s.environment.temperature.rise_K = 12.0;
  return s;
}

TEST(Trajectory, SaysNothingWhereTheOffsetStays) {
  const auto r = test::record(warming(), "", {}, 1);
  const auto t = calibrate_along(r, warming());
  ASSERT_GE(t.t_s.size(), 8U);
  EXPECT_TRUE(examine(t, true).empty()) << examine(t, true).front();
}

TEST(Trajectory, SeesThatTheOffsetItLearnsFollowsTemperature) {
  const std::vector<double> k{8e-4, -5e-4, 6e-4};
  const auto t = calibrate_along(test::record(warming(), "gyr_temp_lin", {{"k_radps_per_K", k}}, 2), warming());
  const Followed f = follow_temperature(t);
  Vec3 moved = Vec3::Zero();  // along with the temperature, step by step, as the course shows it without a replay
  double warmed = 0.0;
  for (std::size_t i = 1; i < t.t_s.size(); ++i) {
    const double dT = t.temp_degC[i] - t.temp_degC[i - 1];
    moved += dT * (t.gyr_bias_radps[i] - t.gyr_bias_radps[i - 1]), warmed += dT * dT;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double truth = k[static_cast<std::size_t>(axis)];
    EXPECT_LT(std::abs(moved[axis]) / warmed, 0.8 * std::abs(truth)) << axis;  // the calibration is behind,
    EXPECT_NEAR(f.k[axis], truth, 0.07 * std::abs(truth)) << axis;             // its replayed copy as well
  }
  const auto said = examine(t, true);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("after temperature"), std::string::npos) << said[0];
}

TEST(Trajectory, AsksForTheTemperatureWhereItWasNotRecorded) {
  auto r = test::record(warming(), "gyr_temp_lin", {{"k_radps_per_K", {2e-3, -2e-3, 2e-3}}}, 3);
  r.temp_degC.clear();
  const auto said = examine(calibrate_along(r, warming()), false);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("record temp_degC"), std::string::npos) << said[0];
}

}  // namespace
}  // namespace stillpoint::diag

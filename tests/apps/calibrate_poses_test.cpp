/// `stillpoint calibrate --recording` of two dozen poses, as they are taken by hand: enough for the magnetometer too.
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

constexpr std::array<double, 3> kHardIron_uT{30, -20, 12};

class CalibratePoses : public ToolInFolder {
 protected:
  nlohmann::json magnetometer(int seed) {
    write_file(folder_ / "sim.yaml",
               "rate_hz: 100\naccelerometer: {noise_mps2: 0.02, bias: [0.1, -0.1, 0.05]}\n"
               "gyroscope: {noise_radps: 0.002, bias: [0.01, -0.01, 0.005], matrix: [[1.004, 0.002, -0.003], "
               "[0.002, 0.995, 0.004], [-0.003, 0.004, 1.006]]}\n"
               "magnetometer: {noise_uT: 0.4, bias: [30, -20, 12], matrix: [[1.02, 0.02, -0.01], [0.02, 0.98, 0.03], "
               "[-0.01, 0.03, 1]]}\nreference: {kind: none}\n"
               "motion: {kind: rest_poses, duration_s: 132, poses: 24, min_rest_s: 4, max_rest_s: 4, move_s: 1.5}\n");
    EXPECT_EQ(tool("simulate --simulation sim.yaml --output poses.csv --seed " + std::to_string(seed)), 0) << told_;
    EXPECT_EQ(tool("calibrate --recording poses.csv --state kept --json out.json"), 0) << told_;
    return nlohmann::json::parse(read_file(folder_ / "out.json")).at("magnetometer");
  }
};

TEST_F(CalibratePoses, TwoDozenTeachTheMagnetometer) {
  for (int seed = 1; seed <= 4; ++seed) {
    std::filesystem::remove(std::string(folder_ / "kept"));
    const auto mag = magnetometer(seed);
    ASSERT_EQ(mag.at("status"), "ok") << seed;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double bias = mag.at("bias")[axis], sd = mag.at("bias_sd")[axis];
      EXPECT_NEAR(bias, kHardIron_uT[axis], 3.0 * sd) << seed;
      EXPECT_LT(sd, 0.2) << seed;
    }
  }
}

TEST_F(CalibratePoses, WhatTheyTaughtIsInTheKeptState) {
  const auto first = magnetometer(1), second = magnetometer(1);
  const auto of = [](const nlohmann::json& mag, const char* key) { return mag.at(key).get<double>(); };
  EXPECT_GT(of(second, "windows"), 1.8 * of(first, "windows"));
  EXPECT_LT(of(second, "norm_sd"), of(first, "norm_sd"));
}

}  // namespace
}  // namespace stillpoint::test

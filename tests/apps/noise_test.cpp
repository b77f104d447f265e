/// `stillpoint noise`: what it prints to paste is a simulation, and that simulation has the noise that was measured.
#include <gmock/gmock.h>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

const std::string kTool = STILLPOINT;

/// The text between two lines of the output.
std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const auto start = text.find(from), end = text.find(to);
  return start == std::string::npos || end == std::string::npos ? "" : text.substr(start, end - start);
}

double number_after(const std::string& text, const std::string& key) {
  const auto at = text.find(key + ": ");
  return at == std::string::npos ? -1.0 : std::stod(text.substr(at + key.size() + 2));
}

TEST(NoiseCommand, ItsBlockIsASimulationOfTheSensorMeasured) {
  const ScratchFolder folder;
  const std::string motion =
      "motion: {kind: hand, duration_s: 400, min_rest_s: 100000, max_rest_s: 100000}\n"
      "environment: {temperature: {kind: constant}}\n";
  write_file(folder / "asked.yaml",
             "accelerometer: {noise_mps2: 0.02, noise_axes: [1, 1, 2]}\n"
             "gyroscope: {noise_radps: 0.001, random_walk_radps_per_sqrts: 3e-4}\n"
             "magnetometer: {noise_uT: 0.4, rate_hz: 25}\n" +
                 motion);
  const auto tool = [&](const std::string& arguments) { return run(kTool + " " + arguments, folder / "err"); };
  ASSERT_EQ(tool("simulate --simulation " + (folder / "asked.yaml") + " --output " + (folder / "rest.csv")), 0);
  ASSERT_EQ(tool("noise --recording " + (folder / "rest.csv") + " --kalibr " + (folder / "imu.yaml") + " --report " +
                 (folder / "allan.html") + " > " + (folder / "out")),
            0);
  const std::string block = between(read_file(folder / "out"), "# simulation block", "# Kalibr");
  write_file(folder / "pasted.yaml", block + motion);
  EXPECT_EQ(tool("check " + (folder / "pasted.yaml") + " > " + (folder / "checked")), 0) << read_file(folder / "err");
  EXPECT_THAT(read_file(folder / "checked"), ::testing::HasSubstr("without fault"));
  EXPECT_NEAR(number_after(block, "noise_mps2"), 0.02, 0.0004);  // 40000 samples: 0.4 % of scatter
  EXPECT_THAT(block, ::testing::ContainsRegex("noise_axes: \\[[0-9.]+, [0-9.]+, (1.9|2)"));
  EXPECT_NEAR(number_after(block, "noise_radps"), 0.001, 2e-5);
  EXPECT_NEAR(number_after(block, "random_walk_radps_per_sqrts"), 3e-4, 1.2e-4);
  EXPECT_NEAR(number_after(block, "noise_uT"), 0.4, 0.012);  // of one reading of the slower sensor, at its own rate
  const std::string mag = block.substr(block.find("magnetometer"));
  EXPECT_NEAR(number_after(mag, "rate_hz"), 25.0, 0.1);
  EXPECT_NEAR(number_after(read_file(folder / "imu.yaml"), "gyroscope_noise_density"), 1e-4, 2e-6);
  const std::string page = read_file(folder / "allan.html");
  for (const char* text : {"Overlapping Allan deviation: gyroscope", "id=\"allan-mag\"", "noise_mps2", "gyr_z fitted"})
    EXPECT_THAT(page, ::testing::HasSubstr(text));
}

TEST(NoiseCommand, ARecordingWithoutATimeStepIsTooShort) {
  const ScratchFolder folder;
  write_file(folder / "one.csv", "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2\n0,1,2,3\n");
  EXPECT_EQ(run(kTool + " noise --recording " + (folder / "one.csv"), folder / "err"), 65);
  EXPECT_THAT(read_file(folder / "err"), ::testing::HasSubstr("has 0 samples; at least 100 are needed"));
}

}  // namespace
}  // namespace stillpoint::test

/// `stillpoint estimate`: from both sides of a recording, and over many of them.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::HasSubstr;

class Estimate : public ToolInFolder {
 protected:
  void SetUp() override {
    write_file(folder_ / "sim.yaml",
               "accelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
               "motion: {kind: hand, duration_s: 5}\n");
    write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
    for (const std::string seed : {"1", "2"})
      ASSERT_EQ(tool("simulate --simulation sim.yaml --seed " + seed + " --output walk" + seed + ".csv"), 0) << told_;
  }
  int estimate(const std::string& arguments) { return tool("estimate --config config.yaml " + arguments); }
};

TEST_F(Estimate, ManyRecordingsGiveTheSameFilesAsOneByOneAndATable) {
  ASSERT_EQ(estimate("--recording walk1.csv --recording walk2.csv --output all --jobs 2 > table"), 0) << told_;
  EXPECT_THAT(told_, HasSubstr("2 of 2: walk"));
  for (const std::string name : {"walk1.csv", "walk2.csv"}) {
    ASSERT_EQ(estimate("--recording " + name + " --output alone.csv > out"), 0) << told_;
    EXPECT_EQ(read_file(folder_ / ("all/" + name)), read_file(folder_ / "alone.csv")) << name;
    EXPECT_THAT(read_file(folder_ / "table"), HasSubstr(name));
  }
}

TEST_F(Estimate, OneThatCannotBeReadCostsTheOthersNothing) {
  write_file(folder_ / "broken.csv", "no recording\n");
  EXPECT_NE(estimate("--recording broken.csv walk1.csv --output all --json all.json > table"), 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "all/walk1.csv"));
  EXPECT_THAT(read_file(folder_ / "table"), HasSubstr("failed: broken.csv"));
  const auto answer = nlohmann::json::parse(read_file(folder_ / "all.json"));
  EXPECT_EQ(answer["schema"], "stillpoint.estimates/1");
  ASSERT_EQ(answer["recordings"].size(), 2);
  EXPECT_THAT(answer["recordings"][0]["error"].get<std::string>(), HasSubstr("broken.csv"));
  EXPECT_EQ(answer["recordings"][1]["output"], "all/walk1.csv");
  EXPECT_GT(answer["recordings"][1]["rows"], 400);
}

/// At 0.2 Hz the attitude was 113 degrees off and stated 16.
TEST_F(Estimate, ASensorThatIsReadTooSlowlyGetsNoAttitude) {
  for (const auto& [rate, says] : {std::pair{"5", "times a second"}, std::pair{"0.2", "s apart"}}) {
    write_file(folder_ / "slow.yaml", std::string("rate_hz: ") + rate +
                                          "\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
                                          "motion: {kind: hand, duration_s: 300}\n");
    ASSERT_EQ(tool("simulate --simulation slow.yaml --output slow.csv"), 0) << told_;
    EXPECT_EQ(estimate("--recording slow.csv --output slow_out.csv"), 65) << told_;
    EXPECT_THAT(told_, HasSubstr(says));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "slow_out.csv"));
  }
}

TEST_F(Estimate, WhatASensorThatIsMissingCostsIsSaid) {
  write_file(folder_ / "gyr.yaml", "gyroscope: {noise_radps: 0.001}\nmotion: {kind: hand, duration_s: 5}\n");
  write_file(folder_ / "acc.yaml", "accelerometer: {noise_mps2: 0.02}\nmotion: {kind: hand, duration_s: 5}\n");
  for (const std::string sensor : {"gyr", "acc"})
    ASSERT_EQ(tool("simulate --simulation " + sensor + ".yaml --output " + sensor + ".csv"), 0) << told_;
  EXPECT_EQ(estimate("--recording gyr.csv --output out.csv"), 65);
  EXPECT_THAT(told_, HasSubstr("no reading of an accelerometer"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.csv"));
  EXPECT_EQ(estimate("--recording acc.csv --output out.csv > text"), 0) << told_;
  EXPECT_THAT(told_, HasSubstr("no reading of a gyroscope"));
}

TEST_F(Estimate, TwoOfOneNameOrAFileForAFolderAreRefusedBeforeAnythingIsWritten) {
  std::filesystem::create_directory(folder_ / "other");
  std::filesystem::copy_file(folder_ / "walk1.csv", folder_ / "other/walk1.csv");
  EXPECT_EQ(estimate("--recording walk1.csv other/walk1.csv --output all"), 64);
  EXPECT_THAT(told_, HasSubstr("walk1.csv and other/walk1.csv would both be written to all/walk1.csv; rename one"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "all/walk1.csv"));
  EXPECT_EQ(estimate("--recording walk1.csv walk2.csv --output sim.yaml"), 73);
  EXPECT_THAT(told_, HasSubstr("several recordings need a folder for --output"));
}

TEST_F(Estimate, SmoothedHasARowForEachAndSaysSo) {
  ASSERT_EQ(estimate("--recording walk1.csv --output causal.csv > out"), 0) << told_;
  ASSERT_EQ(estimate("--recording walk1.csv --smooth --output smooth.csv > said"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "said"), HasSubstr("smooth.csv: 500 rows, smoothed"));
  const std::string causal = read_file(folder_ / "causal.csv"), smooth = read_file(folder_ / "smooth.csv");
  EXPECT_EQ(std::count(causal.begin(), causal.end(), '\n'), std::count(smooth.begin(), smooth.end(), '\n'));
  EXPECT_NE(causal, smooth);
}

}  // namespace
}  // namespace stillpoint::test

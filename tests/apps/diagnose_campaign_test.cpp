/// `stillpoint diagnose` with several recordings.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::HasSubstr;

class DiagnoseCampaign : public ToolInFolder {
 protected:
  void SetUp() override {
    const std::string sensors =
        "rate_hz: 50\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
        "motion: {kind: hand, duration_s: 60}\n";
    write_file(folder_ / "given.yaml", sensors);
    write_file(folder_ / "true.yaml",
               sensors + "effects: [{effect: gyr_gsens, G_radps_per_mps2: [[0,4e-4,0],[0,0,-3e-4],[2e-4,0,0]]}]\n");
    for (const std::string seed : {"1", "2"})
      ASSERT_EQ(tool("simulate --simulation true.yaml --seed " + seed + " --output day" + seed + ".csv"), 0) << told_;
  }
};

TEST_F(DiagnoseCampaign, GivesOneAnswerAndOneSimulation) {
  const std::string both = "diagnose --simulation given.yaml --recording day1.csv day2.csv ";
  ASSERT_EQ(tool(both + "--improved improved.yaml > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("SHARED   gyr_gsens: in 2 of 2 recordings (day1.csv, day2.csv)"));
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("OTHERS   of day1.csv gyr, "));
  EXPECT_THAT(read_file(folder_ / "improved.yaml"), HasSubstr("effect: gyr_gsens"));
  EXPECT_EQ(tool(both + "--json - --fail-on-mismatch > out"), 1) << told_;
  const auto json = nlohmann::json::parse(read_file(folder_ / "out"));
  EXPECT_EQ(json.at("schema"), "stillpoint.campaign/1");
  EXPECT_EQ(json.at("effects").at(0).at("confirmed"), true);
  EXPECT_EQ(tool("diagnose --simulation improved.yaml --recording day1.csv day2.csv --fail-on-mismatch > out"), 0)
      << read_file(folder_ / "out");
}

TEST_F(DiagnoseCampaign, RefusesWhatGoesWithOneRecording) {
  for (const std::string option : {"--report r.html", "--validate other.csv", "--code laws", "--twins 2"}) {
    EXPECT_EQ(tool("diagnose --simulation given.yaml --recording day1.csv day2.csv " + option), 64);
    EXPECT_THAT(told_, HasSubstr(option.substr(0, option.find(' ')) + " goes with one --recording"));
  }
}

}  // namespace
}  // namespace stillpoint::test

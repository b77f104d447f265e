/// Several recordings of one sensor: shared numbers, who agrees, and each judged by what the others say.
#include "diagnosis/campaign/campaign.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

const test::Parameters kGsens{{"G_radps_per_mps2", {0, 4e-4, 0, 0, 0, -3e-4, 2e-4, 0, 0}}};

class CampaignOfThree : public ::testing::Test {
 protected:
  void add(const sim::SimulationConfig& truth, const test::Parameters& gsens, std::uint64_t seed) {
    recordings_.push_back(test::record(truth, "gyr_gsens", gsens, seed));
    files_.push_back(std::to_string(seed) + ".csv");
  }
  void judge() {
    parts_.clear();
    for (std::size_t i = 0; i < recordings_.size(); ++i)
      parts_.push_back({files_[i], &recordings_[i], diagnose(recordings_[i], simulation_)});
    campaign_ = join(parts_, simulation_);
  }
  const SharedEffect& gsens() const {
    static const SharedEffect kNone{};
    for (const SharedEffect& e : campaign_.effects)
      if (e.pooled.effect == "gyr_gsens") return e;
    return kNone;
  }
  static const Parameter& number(const Finding& f, const std::string& name) {
    return *std::find_if(f.parameters.begin(), f.parameters.end(), [&](const Parameter& p) { return p.name == name; });
  }

  sim::SimulationConfig simulation_ = test::baseline("exact", 60.0);
  std::vector<io::Recording> recordings_;
  std::vector<std::string> files_;
  std::vector<CampaignPart> parts_;
  Campaign campaign_;
};

TEST_F(CampaignOfThree, SharesItsNumbersAndEachIsExplainedByTheOthers) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) add(simulation_, kGsens, seed);
  judge();
  const SharedEffect& e = gsens();
  ASSERT_EQ(e.found_in.size(), 3U);
  EXPECT_TRUE(e.apart.empty());
  const Parameter& pooled = number(e.pooled, "G_xy");
  EXPECT_NEAR(pooled.value, 4e-4, 0.5 * 1.5 * (pooled.ci95[1] - pooled.ci95[0]));
  double pooled_width = 0.0, alone_width = 0.0;  // of all nine: one may scatter, and its interval grows
  for (const Parameter& p : e.pooled.parameters) pooled_width += p.ci95[1] - p.ci95[0];
  for (const CampaignPart& part : parts_)
    for (const Parameter& p : part.answer.diagnosis.findings.front().parameters)
      alone_width += (p.ci95[1] - p.ci95[0]) / 3.0;
  EXPECT_LT(pooled_width, 0.8 * alone_width);
  int gyroscopes = 0;
  for (const Validation& v : campaign_.by_others)
    if (v.sensor == "gyr") {
      ++gyroscopes;
      EXPECT_GT(v.share, 0.95) << v.file;
    }
  EXPECT_EQ(gyroscopes, 3);
  const auto improved = improved_by(campaign_, simulation_);
  ASSERT_EQ(improved.effects.size(), 1U);
  EXPECT_NEAR(improved.effects[0].parameters.at("G_radps_per_mps2")[1], 4e-4, 1e-5);
}

TEST_F(CampaignOfThree, TheRecordingOfAnotherSensorDiffers) {
  for (const std::uint64_t seed : {1U, 2U}) add(simulation_, kGsens, seed);
  add(simulation_, {{"G_radps_per_mps2", {0, -4e-4, 0, 0, 0, 3e-4, -2e-4, 0, 0}}}, 3);
  judge();
  const SharedEffect& e = gsens();
  EXPECT_THAT(e.apart, testing::Contains(2U));
  const Parameter& pooled = number(e.pooled, "G_xy");
  EXPECT_GT(pooled.ci95[1] - pooled.ci95[0], 3e-4) << "numbers that scatter so are not known to their own deviation";
  for (const Validation& v : campaign_.by_others)
    if (v.sensor == "gyr" && v.file == "3.csv") {
      EXPECT_LT(v.ci95[1], 0.0) << "the others make it worse";
    }
}

TEST_F(CampaignOfThree, AnEventOfOneDayIsNotShared) {
  for (const std::uint64_t seed : {1U, 2U}) add(simulation_, kGsens, seed);
  auto magnet = simulation_;
  magnet.effects.push_back(
      {.id = "mag_hard_step", .parameters = {{"b_uT", {6, -4, 5}}, {"t0_s", {30}}}, .axes = {}, .window_s = {}});
  add(magnet, kGsens, 3);
  judge();
  EXPECT_EQ(campaign_.effects.size(), 1U);
  EXPECT_THAT(campaign_.own, testing::ElementsAre(testing::StartsWith("3.csv: mag_hard_step in mag")));
  EXPECT_THAT(to_text(campaign_, parts_), testing::HasSubstr("SHARED   gyr_gsens: in 3 of 3 recordings"));
  const auto json = nlohmann::json::parse(to_json(campaign_, parts_));
  EXPECT_EQ(json.at("effects").at(0).at("found_in").size(), 3U);
  EXPECT_EQ(json.at("recordings").size(), 3U);
}

}  // namespace
}  // namespace stillpoint::diag

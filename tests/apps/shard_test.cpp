/// `stillpoint estimate --shard` and `merge`: parts that make the whole, and what is refused.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Shards : public ToolInFolder {
 protected:
  void SetUp() override {
    write_file(folder_ / "sim.yaml", "accelerometer: {noise_mps2: 0.02}\nmotion: {kind: hand, duration_s: 2}\n");
    write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
    ASSERT_EQ(tool("simulate --simulation sim.yaml --output a.csv"), 0) << told_;
    for (const std::string name : {"b", "c", "d", "e"})
      std::filesystem::copy_file(folder_ / "a.csv", folder_ / (name + ".csv"));
  }
  int shard(const std::string& name, const std::string& recordings = "a.csv b.csv c.csv d.csv e.csv") {
    return tool("estimate --config config.yaml --output att --shard " + name + " --json " + name.substr(0, 1) +
                ".json --recording " + recordings + " > out");
  }
  nlohmann::json json(const std::string& name) { return nlohmann::json::parse(read_file(folder_ / name)); }
};

TEST_F(Shards, TogetherAreWhatOneRunWouldHaveWritten) {
  ASSERT_EQ(shard("1/3"), 0) << told_;
  ASSERT_EQ(shard("2/3", "e.csv d.csv c.csv b.csv a.csv"), 0) << "the order of the list does not count; " << told_;
  ASSERT_EQ(shard("3/3"), 0) << told_;
  EXPECT_EQ(json("1.json")["recordings"].size(), 2U);
  EXPECT_EQ(json("3.json")["recordings"].size(), 1U);
  ASSERT_EQ(tool("merge 3.json 1.json 2.json --json all.json --csv all.csv > out"), 0) << told_;
  ASSERT_EQ(tool("estimate --config config.yaml --output whole --json whole.json --recording a.csv b.csv c.csv d.csv "
                 "e.csv > table"),
            0);
  const auto merged = json("all.json"), whole = json("whole.json");
  ASSERT_EQ(merged["recordings"].size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(merged["recordings"][i]["recording"], whole["recordings"][i]["recording"]);
    EXPECT_EQ(merged["recordings"][i]["rows"], whole["recordings"][i]["rows"]);
  }
  EXPECT_EQ(merged["totals"]["rows"], 5 * whole["recordings"][0]["rows"].get<int>());
  EXPECT_EQ(merged["totals"]["recordings"], 5);
  EXPECT_EQ(merged["missing_shards"].size(), 0U);
  EXPECT_EQ(read_file(folder_ / "att/e.csv"), read_file(folder_ / "whole/e.csv"));
  const std::string csv = read_file(folder_ / "all.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 6);
  EXPECT_THAT(csv, AllOf(HasSubstr("recording,rows,"), HasSubstr("\ne.csv,")));
}

TEST_F(Shards, ThatAreMissingAreToldAndTheRestIsMerged) {
  ASSERT_EQ(shard("2/4"), 0) << told_;
  ASSERT_EQ(shard("4/4"), 0) << told_;
  EXPECT_EQ(tool("merge 2.json 4.json --json all.json > out"), 66);
  EXPECT_THAT(told_, HasSubstr("2 of 4 shards are missing: 1, 3"));
  EXPECT_EQ(json("all.json")["missing_shards"], nlohmann::json({1, 3}));
  EXPECT_EQ(json("all.json")["totals"]["recordings"], 2);
}

TEST_F(Shards, ThatOverlapOrAreOfAnotherListAreRefused) {
  ASSERT_EQ(shard("1/2"), 0) << told_;
  std::filesystem::copy_file(folder_ / "1.json", folder_ / "again.json");
  EXPECT_EQ(tool("merge 1.json again.json --json all.json > out"), 65);
  EXPECT_THAT(told_, HasSubstr("1.json and again.json are both shard 1 of 2"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "all.json"));
  ASSERT_EQ(shard("2/2", "a.csv b.csv c.csv"), 0) << told_;
  EXPECT_EQ(tool("merge 1.json 2.json > out"), 65);
  EXPECT_THAT(told_, HasSubstr("1.json and 2.json are no parts of one list"));
  auto overlapping = json("1.json");
  overlapping["shard"]["index"] = 2;
  write_file(folder_ / "2.json", overlapping.dump());
  EXPECT_EQ(tool("merge 1.json 2.json > out"), 65);
  EXPECT_THAT(told_, HasSubstr("'a.csv' stands in 1.json and in 2.json"));
  write_file(folder_ / "cut.json", read_file(folder_ / "1.json").substr(0, 40));
  EXPECT_EQ(tool("merge cut.json > out"), 65);
  EXPECT_THAT(told_, HasSubstr("cut.json: no JSON; was its job cut short?"));
  for (const std::string odd :
       {"[]", "{}", "3", R"({"schema": "stillpoint.estimates/1"})",
        R"({"schema": "stillpoint.estimates/1", "recordings": [{"recording": 3}]})",
        R"({"schema": "stillpoint.estimates/1", "recordings": [], "shard": {"index": 3, "of": 2}})",
        R"({"schema": "stillpoint.estimates/1", "recordings": [{"recording": "a", "rows": -1}]})"}) {
    write_file(folder_ / "odd.json", odd);
    EXPECT_EQ(tool("merge odd.json > out"), 65) << odd;
  }
  EXPECT_EQ(tool("merge gone.json"), 66);
}

TEST_F(Shards, AFailureIsInItsTableAndCounted) {
  write_file(folder_ / "b.csv", "no recording\n");
  EXPECT_EQ(shard("1/2"), 0) << told_;
  EXPECT_EQ(shard("2/2"), 65) << told_;
  ASSERT_EQ(tool("merge 1.json 2.json --json all.json > out"), 0) << told_;
  EXPECT_EQ(json("all.json")["totals"]["failed"], 1);
  EXPECT_THAT(read_file(folder_ / "out"), AllOf(HasSubstr("failed: b.csv"), HasSubstr("5 recordings, 1 failed")));
}

TEST_F(Shards, AShardWithoutRecordingsIsAnEmptyTableAndTwoOfOneNameAreRefusedByEveryShard) {
  EXPECT_EQ(shard("3/3", "a.csv b.csv"), 0) << told_;
  EXPECT_EQ(json("3.json")["recordings"].size(), 0U);
  std::filesystem::create_directory(folder_ / "other");
  std::filesystem::copy_file(folder_ / "a.csv", folder_ / "other/a.csv");
  for (const std::string name : {"1/2", "2/2"}) EXPECT_EQ(shard(name, "a.csv other/a.csv"), 64) << name;
}

TEST_F(Shards, ANameThatIsNoPartIsWrongUsage) {
  for (const std::string name : {"0/4", "5/4", "1", "1/", "/4", "1/4x", "-1/4", "a/b", "1/99999999999999999999"})
    EXPECT_EQ(shard(name), 64) << name << told_;
  EXPECT_EQ(tool("estimate --config config.yaml --output att --shard 1/2 --recording a.csv b.csv"), 64);
  EXPECT_THAT(told_, HasSubstr("--shard needs --json FILE"));
}

}  // namespace
}  // namespace stillpoint::test

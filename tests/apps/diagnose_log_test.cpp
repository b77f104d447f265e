/// `stillpoint diagnose --simulated LOG.csv`: the log of another simulator from the command line, and everything that
/// such a log can be wrong in.
#include <gmock/gmock.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "io/recording.h"
#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr auto kMotion = "motion: {kind: hand, duration_s: 60}\n";

class DiagnoseLog : public ToolInFolder {
 protected:
  /// rec.csv: a sensor whose gyroscope feels force; log.csv: what another simulator says of the same motion, at its own
  /// rate and without noise.
  void SetUp() override {
    simulate("rec",
             std::string("rate_hz: 100\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
                         "effects: [{effect: gyr_gsens, G_radps_per_mps2: [[0,4e-4,0],[0,0,-3e-4],[2e-4,0,0]]}]\n") +
                 kMotion);
    simulate("log",
             std::string("rate_hz: 83\naccelerometer: {noise_mps2: 0}\ngyroscope: {noise_radps: 0}\n") + kMotion);
    change("log", [](io::Recording& r) {  // another program knows neither our reference nor our temperature
      r.ref_q_world_body.clear(), r.ref_position_m.clear(), r.ref_moving.clear();
      r.temp_degC.clear(), r.current_A.clear(), r.supply_V.clear();
    });
  }
  void simulate(const std::string& name, const std::string& yaml) {
    write_file(folder_ / (name + ".yaml"), yaml);
    ASSERT_EQ(tool("simulate --simulation " + name + ".yaml --seed 3 --output " + name + ".csv"), 0) << told_;
  }
  /// NAME.csv with the change in it, as TO.csv.
  void change(const std::string& name, const std::function<void(io::Recording&)>& how, const std::string& to = "") {
    auto r = io::read_recording(folder_ / (name + ".csv"));
    ASSERT_TRUE(r) << r.error().message;
    how(*r);
    ASSERT_TRUE(io::write_recording(*r, folder_ / ((to.empty() ? name : to) + ".csv")));
  }
  /// `log.csv` changed so is refused with 65 and the file's name, and nothing is written.
  void expect_refused(const std::function<void(io::Recording&)>& how, const std::string& words) {
    change("log", how, "wrong");
    EXPECT_EQ(tool("diagnose --simulated wrong.csv --recording rec.csv --improved better.csv --json out.json > out"),
              65);
    EXPECT_THAT(told_, AllOf(HasSubstr("wrong.csv: "), HasSubstr(words)));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "better.csv")) << words;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.json")) << words;
    EXPECT_EQ(read_file(folder_ / "out"), "") << words;
  }
};

/// The rows from `first` up to `end`.
void keep(io::Recording& r, std::size_t first, std::size_t end) {
  const auto cut = [&](auto& column) {
    if (!column.empty())
      column = {column.begin() + static_cast<std::ptrdiff_t>(first), column.begin() + static_cast<std::ptrdiff_t>(end)};
  };
  cut(r.t_ns), cut(r.acc_mps2), cut(r.gyr_radps);
}

TEST_F(DiagnoseLog, NamesThePhysicsAndWritesALogThatLeavesNothingToFind) {
  const std::string to = " --recording rec.csv --fail-on-mismatch ";
  ASSERT_EQ(tool("diagnose --simulated log.csv" + to + "--improved better.csv --json - > out"), 1) << told_;
  const auto json = nlohmann::json::parse(read_file(folder_ / "out"));
  EXPECT_EQ(json.at("verdict"), "explained");
  EXPECT_EQ(json.at("findings").at(0).at("effect"), "gyr_gsens");
  EXPECT_EQ(tool("diagnose --simulated better.csv" + to + "> out"), 0) << read_file(folder_ / "out");
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("VERDICT  No mismatch"));
}

/// An effect of the catalogue is code as well; with the numbers of the sensor that belong to it.
TEST_F(DiagnoseLog, WritesCodeForTheCatalogueToo) {
  simulate("scaled",
           std::string("rate_hz: 100\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001, matrix: "
                       "[[0.9,0,0],[0,0.9,0],[0,0,0.9]]}\n"
                       "effects: [{effect: gyr_gsens, G_radps_per_mps2: [[0,4e-4,0],[0,0,-3e-4],[2e-4,0,0]]}]\n") +
               kMotion);
  EXPECT_EQ(tool("diagnose --simulated log.csv --recording scaled.csv --code laws > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), AllOf(HasSubstr("gyr_gsens"), HasSubstr("they belong to these numbers"),
                                                HasSubstr("gyroscope: {bias: [")));
  EXPECT_THAT(read_file(folder_ / "laws/law_1.py"),
              AllOf(HasSubstr("a matrix times"), HasSubstr("it reads M (truth + this) + b"), HasSubstr("M = [[1.11")));
}

TEST_F(DiagnoseLog, SaysWhatHasNoCode) {
  simulate("clipped", std::string("rate_hz: 100\naccelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
                                  "effects: [{effect: gyr_sat, L_radps: [2.5, 2.5, 2.5]}]\n") +
                          kMotion);
  EXPECT_EQ(tool("diagnose --simulated log.csv --recording clipped.csv --code laws --json - > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("no code for gyr_sat: the grammar of laws has no words for"));
}

TEST_F(DiagnoseLog, ThatCannotBeComparedIsRefusedWithWhatToDo) {
  const auto from = [](double s) { return static_cast<std::size_t>(83 * s); };
  expect_refused([&](io::Recording& r) { keep(r, 0, from(8)); }, "overlap by");
  change(
      "rec",
      [](io::Recording& r) {
        keep(r, 0, 3000), r.ref_q_world_body.resize(3000), r.ref_position_m.resize(3000), r.ref_moving.clear(),
            r.temp_degC.clear();
      },
      "first_half");
  change(
      "log", [&](io::Recording& r) { keep(r, from(31), r.size()); }, "second_half");
  EXPECT_EQ(tool("diagnose --simulated second_half.csv --recording first_half.csv > out"), 65);
  EXPECT_THAT(told_, HasSubstr("second_half.csv: the simulated log is of another motion"));
  expect_refused([](io::Recording& r) { std::reverse(r.gyr_radps.begin(), r.gyr_radps.end()); },
                 "replay the recording's motion");
  expect_refused(
      [](io::Recording& r) {
        for (Vec3& w : r.gyr_radps) w *= 57.29578;
      },
      "it looks like deg/s (name its columns gyr_x_dps, ...)");
  expect_refused(
      [](io::Recording& r) {
        for (Vec3& f : r.acc_mps2) f /= 9.80665;
      },
      "it looks like g (name its columns acc_x_g, ...)");
  expect_refused(
      [](io::Recording& r) {
        for (Vec3& w : r.gyr_radps) w = Vec3(w.y(), -w.x(), w.z());
      },
      "import it with mount: \"-y +x +z\"");
  expect_refused(
      [](io::Recording& r) {
        for (Vec3& w : r.gyr_radps) w.x() = -w.x();
      },
      "one of the two is left-handed");
  expect_refused(
      [](io::Recording& r) { r.acc_mps2.clear(), r.gyr_radps.clear(), r.mag_uT.assign(r.size(), Vec3(20, 0, -40)); },
      "share neither a gyroscope nor an accelerometer");
}

TEST_F(DiagnoseLog, ThatHoldsTheNoiseTwiceIsTold) {
  simulate("noisy",
           std::string("rate_hz: 83\naccelerometer: {noise_mps2: 0.05}\ngyroscope: {noise_radps: 0.003}\n") + kMotion);
  tool("diagnose --simulated noisy.csv --recording rec.csv > out");
  EXPECT_THAT(read_file(folder_ / "out"),
              AllOf(HasSubstr("gyr: the simulated log is noisier"), HasSubstr("the noise may be in it twice")));
}

TEST_F(DiagnoseLog, ColumnsOfOtherNamesGoThroughAMapAndMistakesNameTheNearest) {
  std::string text = read_file(folder_ / "log.csv");
  const std::string ours = "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps";
  const auto at = text.find(ours);
  ASSERT_NE(at, std::string::npos) << text.substr(0, 300);
  const std::string rows = text.substr(at + ours.size());
  const auto diagnose = [&](const std::string& header, const std::string& map) {
    write_file(folder_ / "their.csv", header + rows);
    write_file(folder_ / "map.yaml", map);
    return tool("diagnose --simulated their.csv --recording rec.csv --json - " +
                std::string(map.empty() ? "" : "--map map.yaml ") + "> out");
  };
  const std::string their = "stamp,fx,fy,fz,p,q,r";
  const std::string map =
      "time: {column: stamp, unit: ns}\nacc: {columns: [fx, fy, fz], unit: m/s^2}\ngyr: {columns: [p, q, r], unit: "
      "rad/s}\n";
  EXPECT_EQ(diagnose(their, map), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("gyr_gsens"));
  const auto replaced = [&](const std::string& what, const std::string& with) {
    std::string m = map;
    return m.replace(m.find(what), what.size(), with);
  };
  EXPECT_EQ(diagnose(their, replaced("stamp", "stanp")), 65);
  EXPECT_THAT(told_, HasSubstr("no column 'stanp'; did you mean 'stamp'?"));
  EXPECT_EQ(diagnose(their, replaced("m/s^2", "ft/s^2")), 78);
  EXPECT_THAT(told_, HasSubstr("'ft/s^2' is no unit of acc"));
  EXPECT_EQ(diagnose(their, replaced("gyr", "gyro")), 78);
  EXPECT_THAT(told_, HasSubstr("map.yaml:3:1: unknown key 'gyro'; did you mean 'gyr'?"));
  EXPECT_EQ(diagnose("time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_rads", ""), 65);
  EXPECT_THAT(told_, HasSubstr("'gyr_z_rads' is not known; did you mean 'gyr_z_radps'?"));
  EXPECT_EQ(diagnose("time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radsp,gyr_y_radsp,gyr_z_radsp", ""), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("their.csv: column 'gyr_x_radsp' is not known, its numbers are "
                                                    "kept under this name; did you mean 'gyr_x_radps'?"));
}

TEST_F(DiagnoseLog, OptionsThatDoNotGoTogetherAreWrongUsage) {
  for (const auto& [options, words] :
       {std::pair{"--simulated log.csv --simulation rec.yaml --recording rec.csv", "--simulation"},
        {"--simulated log.csv --recording rec.csv --validate rec.csv", "--validate"},
        {"--simulation rec.yaml --recording rec.csv --map rec.yaml", "--simulated"},
        {"--recording rec.csv", "--simulated LOG.csv of any simulator"},
        {"--simulated log.csv --recording rec.csv other.csv", "--simulated goes with one --recording"}}) {
    EXPECT_EQ(tool(std::string("diagnose ") + options), 64) << options;
    EXPECT_THAT(told_, HasSubstr(words)) << options;
  }
  EXPECT_EQ(tool("diagnose --simulated nothing.csv --recording rec.csv"), 66);
  EXPECT_EQ(tool("diagnose --simulated log.csv --recording rec.csv --improved no/folder.csv"), 73);
}

}  // namespace
}  // namespace stillpoint::test

/// `stillpoint calibrate --points`: whatever the table holds, the answer is a calibration or a status with its reason.
#include <gmock/gmock.h>

#include <random>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string> kMethods{"lin_auto", "lin_auto_repeated", "lin_min_var", "non_linear", "lsq_non_linear",
                                        "mgn",      "min_vol_ellipsoid", "manual",      "adjusted",   "map"};

/// Six positions and some more, on a sphere of 500 about (2300, 2310, 2290), uneven by a count or two.
std::string good_table() {
  std::string text =
      "x,y,z\n2801,2310,2290\n1798,2310,2290\n2300,2812,2290\n2300,1811,2290\n2300,2310,2789\n"
      "2300,2310,1788\n";
  int uneven = 0;
  for (const int x : {-1, 1})
    for (const int y : {-1, 1})
      for (const int z : {-1, 1}) {
        text += std::to_string(2300 + (288 + uneven % 3) * x) + "," + std::to_string(2310 + (288 + uneven % 4) * y) +
                "," + std::to_string(2290 + 288 * z) + "\n";
        ++uneven;
      }
  return text;
}

struct Answer {
  int exit_code = -1;
  std::string json, reason;
};
Answer calibrate(const ScratchFolder& folder, const std::string& table, const std::string& method) {
  write_file(folder / "points.csv", table);
  Answer a;
  a.exit_code = run(std::string(STILLPOINT) + " calibrate --points " + (folder / "points.csv") + " --method " + method +
                        " --json " + (folder / "out.json"),
                    folder / "err");
  a.json = read_file(folder / "out.json");
  a.reason = read_file(folder / "err");
  return a;
}

TEST(CalibratePoints, AGoodTableGivesACalibrationByEveryMethod) {
  const ScratchFolder folder;
  for (const auto& method : kMethods) {
    const Answer a = calibrate(folder, good_table(), method);
    EXPECT_EQ(a.exit_code, 0) << method << a.reason;
    EXPECT_THAT(a.json, HasSubstr("\"status\": \"ok\"")) << method;
  }
}

TEST(CalibratePoints, ABadTableGivesItsStatusAndReason) {
  const auto repeated = [](const std::string& row, int times) {
    std::string text = "x,y,z\n";
    for (int k = 0; k < times; ++k) text += row;
    return text;
  };
  std::string coplanar = "x,y,z\n", line = coplanar;
  for (int k = 0; k < 30; ++k) {
    coplanar += std::to_string(k % 7) + "," + std::to_string(k * k % 11) + ",5\n";
    line += std::to_string(k) + "," + std::to_string(k) + "," + std::to_string(k) + "\n";
  }
  const struct {
    std::string table, status;
  } cases[] = {{"", "bad_input"},
               {"a,b,c\n1,2,3\n", "bad_input"},
               {"x,y,z\n1,2\n", "bad_input"},
               {"x,y,z\n1,2,3\nnan,2,3\n4,5,6\n7,8,1\n", "bad_input"},
               {"x,y,z\ninf,2,3\n", "bad_input"},
               {"x,y,z\nseven,2,3\n", "bad_input"},
               {"x,y,z,var\n1,0,0,-1\n", "bad_input"},
               {"x,y,z\n", "too_few_points"},
               {"x,y,z\n1,2,3\n4,5,6\n7,8,1\n", "too_few_points"},
               {repeated("1,2,3\n", 30), "too_few_points"},
               {coplanar, "not_observable"},
               {line, "not_observable"}};
  const ScratchFolder folder;
  for (const auto& c : cases)
    for (const char* method : {"lin_auto", "min_vol_ellipsoid", "map"}) {
      const Answer a = calibrate(folder, c.table, method);
      EXPECT_EQ(a.exit_code, 65) << c.table << method;
      EXPECT_THAT(a.json, HasSubstr("\"status\": \"" + c.status + "\"")) << c.table << method;
      EXPECT_THAT(a.json, Not(HasSubstr("\"reason\": \"\""))) << c.table << method;
      EXPECT_THAT(a.reason, HasSubstr(c.status)) << c.table << method;
    }
}

TEST(CalibratePoints, OptionsOfTheOtherHalfAndNumbersThatAreNoneAreWrongUsage) {
  const ScratchFolder folder;
  write_file(folder / "points.csv", good_table());
  const std::string points = " --points " + (folder / "points.csv") + " --method map";
  for (const std::string& wrong :
       {std::string(" --recording a.csv --method map"), points + " --recording a.csv", points + " --state s",
        points + " --initial-radius nan", points + " --initial-radius -3", points + " --initial-centre 1 2",
        points + " --prior-sd 0", " --points " + (folder / "points.csv")})
    EXPECT_EQ(run(std::string(STILLPOINT) + " calibrate" + wrong, folder / "err"), 64) << wrong;
}

TEST(CalibratePoints, AMessageQuotesNothingThatSteersATerminal) {
  const ScratchFolder folder;
  const Answer a = calibrate(folder, "\x1b[2J\x07\xff" + std::string(5000, 'k') + "\n1,2,3\n", "map");
  EXPECT_EQ(a.exit_code, 65);
  EXPECT_THAT(a.reason, HasSubstr("'?[2J??kkk"));
  EXPECT_LT(a.reason.size(), 400U);
}

TEST(CalibratePoints, ADamagedTableNeverEndsTheProgram) {
  const ScratchFolder folder;
  std::mt19937 random(5);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (int k = 0; k < 60; ++k) {
    std::string table = k % 10 == 0 ? std::string(400, '\0') : good_table();
    for (std::size_t times = 1 + below(k % 10 == 0 ? 400 : 6); times > 0 && !table.empty(); --times) {
      const std::size_t at = below(table.size());
      if (below(3) == 0)
        table.erase(at, 1 + below(20));
      else
        table[at] = static_cast<char>(below(3) == 0 ? below(256) : "0123456789,.-e\n"[below(15)]);
    }
    const Answer a = calibrate(folder, table, kMethods[static_cast<std::size_t>(k) % kMethods.size()]);
    EXPECT_TRUE(a.exit_code == 0 || a.exit_code == 65) << a.exit_code << "\n" << table;
    EXPECT_THAT(a.json, HasSubstr("\"status\": ")) << table;
    EXPECT_EQ(a.exit_code == 0, a.json.find("\"status\": \"ok\"") != std::string::npos) << table;
  }
}

}  // namespace
}  // namespace stillpoint::test

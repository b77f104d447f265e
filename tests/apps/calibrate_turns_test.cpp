/// `stillpoint calibrate --recording --turn --rate`: a gyroscope that is far off is known after a turn about each axis,
/// and what cannot be used says why.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "tests/apps/apps_testing.h"
#include "tests/calib_online/synthetic.h"

namespace stillpoint::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr double kKnownTurn_s = 4.0, kPi = 3.14159265358979323846;

/// Rests, once around about each axis on a table, tipped by a quarter in between; then 20 s on a turntable.
class CalibrateTurns : public ::testing::Test {
 protected:
  CalibrateTurns() {
    truth_.H_gyr << 1.3, 0.012, -0.008, -0.01, 0.9, 0.011, 0.007, -0.012, 1.01;
    truth_.b_gyr = Vec3(0.01, -0.02, 0.015);
    truth_.has_mag = false;
    std::ofstream csv(recording());
    csv << "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";
    Synthetic source(truth_, 12);
    const auto rest = [&] { run(source, csv, 7.0, {}); };
    const auto turn = [&](const Vec3& axis, double angle_rad) {
      run(source, csv, kKnownTurn_s, [=](double t) {
        return Vec3(angle_rad / kKnownTurn_s * (1.0 - std::cos(2.0 * kPi * t / kKnownTurn_s)) * axis);
      });
    };
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
    rest();
    turn(z, 2.0 * kPi);  // 7 to 11 s
    rest();
    turn(y, 0.5 * kPi);
    rest();
    turn(x, -2.0 * kPi);  // 29 to 33 s
    rest();
    turn(z, 0.5 * kPi);
    rest();
    turn(y, 2.0 * kPi);  // 51 to 55 s
    rest();
    run(source, csv, 20.0, [](double) { return Vec3(200.0 * kPi / 180.0 * Vec3::UnitY()); });  // 62 to 82 s
    rest();
  }
  [[nodiscard]] std::string recording() const { return folder_ / "turns.csv"; }
  int calibrate(const std::string& options) {
    const int code = test::run(
        std::string(STILLPOINT) + " calibrate --recording " + recording() + " " + options + " > " + (folder_ / "out"),
        folder_ / "err");
    told_ = read_file(folder_ / "err");
    shown_ = read_file(folder_ / "out");
    return code;
  }
  Json json(const std::string& options) {
    EXPECT_EQ(calibrate(options + " --json -"), 0) << told_;
    return Json::parse(shown_);
  }

  SensorTruth truth_;
  ScratchFolder folder_;
  std::string told_, shown_;

 private:
  static void run(Synthetic& source, std::ofstream& csv, double seconds, std::function<Vec3(double)> rate) {
    Motion motion;
    if (rate) motion.rate_radps = std::move(rate);
    source.run(seconds, motion, [&csv](const RawSample& s) {
      csv << in_seconds(s.t_ns - 1'000'000'000);
      for (const double v : s.acc_mps2) csv << ',' << v;
      for (const double v : s.gyr_radps) csv << ',' << v;
      csv << '\n';
    });
  }
};

const std::string kThree = "--turn 5:13:360 --turn 27:35:360 --turn 49:57:-360";

TEST_F(CalibrateTurns, OneAboutEachAxisMakesTheMatrixKnown) {
  const Json without = json(""), with = json(kThree);
  EXPECT_GT(std::abs(without["gyroscope"]["matrix"][0][0].get<double>() - 1.3), 0.1);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double sd = with["gyroscope"]["matrix_sd"][i][j];
      EXPECT_NEAR(with["gyroscope"]["matrix"][i][j], truth_.H_gyr(i, j), 3.0 * sd) << i << j;
      if (i == j) {
        EXPECT_LT(sd, 0.008);
      }
    }
  ASSERT_EQ(with["known_turns"].size(), 3U);
  const Json& first = with["known_turns"][1];
  EXPECT_TRUE(first["used"]);
  EXPECT_EQ(first["begin_s"], 27.0);
  EXPECT_EQ(first["stated"], 360.0);
  EXPECT_NEAR(first["before"], 360.0 / 1.3, 1.0);
  EXPECT_NEAR(first["after"], 360.0, 1.5);
  EXPECT_LT(std::abs(first["residual_sd"].get<double>()), 1.0);
  EXPECT_EQ(without["known_turns"].size(), 0U);
  // The quarter turns between them are understood then.
  for (const Json& q : with["quantities"])
    if (q["name"] == "gyroscope, matrix") {
      EXPECT_EQ(q["refused"], 0) << q;
    }
  EXPECT_THAT(told_, HasSubstr("--turn 27:35:360: stated 360 +- 1.5 deg, read 27"));
  EXPECT_THAT(told_, HasSubstr("the scale is +30 % off"));
}

TEST_F(CalibrateTurns, ATurntableSpeaksOfItsOwnAxis) {
  const Json run = json("--rate 63:81:33.3333rpm");
  const Json& g = run["gyroscope"];
  EXPECT_NEAR(g["matrix"][1][1], 0.9, 3.0 * g["matrix_sd"][1][1].get<double>());
  EXPECT_LT(g["matrix_sd"][1][1], 0.006);
  EXPECT_GT(g["matrix_sd"][0][0], 0.02);
  EXPECT_EQ(run["known_turns"][0]["unit"], "deg/s");
  EXPECT_NEAR(run["known_turns"][0]["after"], 200.0, 0.6);
}

TEST_F(CalibrateTurns, TextPageAndStateHoldThem) {
  ASSERT_EQ(calibrate(kThree + " --report " + (folder_ / "page.html") + " --state " + (folder_ / "imu.state")), 0);
  EXPECT_THAT(shown_, HasSubstr("turn from 27 to 35 s: stated 360 +- 1.5 deg, read "));
  EXPECT_THAT(read_file(folder_ / "page.html"), HasSubstr("Turns of known angle"));
  // The next run, as the daemon, goes on with them.
  const Json next = json("--state " + (folder_ / "imu.state"));
  EXPECT_NEAR(next["gyroscope"]["matrix"][0][0], 1.3, 0.02);
}

TEST_F(CalibrateTurns, AnAngleThatOtherTurnsContradictIsTold) {
  const Json run = json("--turn 5:13:360 --turn 27:35:360 --turn 49:57:360 --turn 50:56:500");
  EXPECT_TRUE(run["known_turns"][2]["used"]);
  EXPECT_FALSE(run["known_turns"][3]["used"]);
  EXPECT_THAT(told_, HasSubstr("--turn 50:56:500: stated 500 +- 1.5 deg, read "));
  EXPECT_THAT(told_, HasSubstr("what is known of the gyroscope contradicts it"));
}

TEST_F(CalibrateTurns, WhatTheRecordingDoesNotShowIsRefusedWithItsReason) {
  const struct {
    std::string option, reason;
  } cases[] = {{"--turn 5:1300:360", "the recording lasts"},
               {"--turn 9:13:360", "at 9 s it turns by"},
               {"--turn 1:5:360", "deg only, and 20 are the least"},
               {"--turn 16:35:360", "the axis moves in the body"},
               {"--rate 55:75:200", "the rate is not steady"}};
  for (const auto& c : cases) {
    EXPECT_EQ(calibrate(c.option), 65) << c.option;
    EXPECT_THAT(told_, HasSubstr("turns.csv: " + c.option + ": ")) << c.option;
    EXPECT_THAT(told_, HasSubstr(c.reason)) << c.option;
    EXPECT_EQ(shown_, "") << c.option;
  }
}

TEST_F(CalibrateTurns, WhatIsNoTurnIsWrongUsage) {
  for (const std::string wrong :
       {"--turn 5:13", "--turn 5:13:", "--turn 5:13:x", "--turn 5:13:0", "--turn 13:5:360", "--turn -1:5:360",
        "--turn 5:13:360:0", "--turn 5:13:360:90", "--turn 5:13:nan", "--turn 5:13:360:1:1", "--turn 5:13:360rpm",
        "--rate 63:81:33rpm3", "--rate 63:81", "--rate 63:81:0", "--rate 63:63:200", "--turn 5:13:1e300"}) {
    EXPECT_EQ(calibrate(wrong), 64) << wrong;
    EXPECT_NE(told_, "") << wrong;
  }
  EXPECT_EQ(test::run(std::string(STILLPOINT) + " calibrate --turn 5:13:360", folder_ / "err"), 64);
}

}  // namespace
}  // namespace stillpoint::test

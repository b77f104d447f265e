/// Sensors and files that are not taken: every one is named.
#include <gmock/gmock.h>

#include <filesystem>

#include "core/units.h"
#include "tests/exchange/foreign_files.h"
#include "tests/exchange/importing.h"

namespace stillpoint::exchange {
namespace {

using test::all;
using test::file;
using test::read;
using testing::HasSubstr;
using testing::Not;

std::string table_of(const std::vector<RawSample>& samples, const std::string& header, double gyr_factor) {
  return test::table(samples,
                     {header, ",", 1.0, 0, {{&RawSample::acc_mps2, 1.0}, {&RawSample::gyr_radps, gyr_factor}}});
}

TEST(LeftOut, NamesOfGyroscopesAsManyProgramsWriteThem) {
  const auto truth = test::hand();
  struct Names {
    const char *x, *y, *z;
    double factor;
  };
  for (const auto& [x, y, z, factor] :
       {Names{"gyro_x_rad", "gyro_y_rad", "gyro_z_rad", 1.0},
        {"gyro_x_deg", "gyro_y_deg", "gyro_z_deg", kDegPerRad},
        {"AngularvelocityX(deg/s)", "AngularvelocityY(deg/s)", "AngularvelocityZ(deg/s)", kDegPerRad},
        {"AngularVelocityX(deg/s)", "AngularVelocityY(deg/s)", "AngularVelocityZ(deg/s)", kDegPerRad},
        {"gyro1_x", "gyro1_y", "gyro1_z", 1.0}}) {
    const std::string header = fmt::format("t,ax,ay,az,{},{},{}", x, y, z);
    const auto imported = read(file("names.csv", table_of(truth, header, factor)));
    ASSERT_EQ(imported.recording.gyr_radps.size(), truth.size()) << header;
    EXPECT_NEAR(imported.recording.gyr_radps[900].x(), truth[900].gyr_radps[0], 1e-6) << header;
    EXPECT_THAT(all(imported.reasons), Not(HasSubstr("not taken"))) << header;
  }
}

TEST(LeftOut, ColumnsThatNoNameTellsAreListed) {
  const auto truth = test::hand();
  const auto imported = read(file("left.csv", table_of(truth, "t,ax,ay,az,rot1,rot2,seconds_elapsed", 1.0)));
  EXPECT_THAT(all(imported.reasons), HasSubstr("left.csv: not taken: rot1, rot2\n"));
}

TEST(LeftOut, SensorLoggersGravityAndTheRestAreSummed) {
  const auto truth = test::hand();
  auto late = truth;
  for (auto& s : late) s.t_ns += 1'000'000;
  const auto one = [](const std::vector<RawSample>& samples, Array3 RawSample::*vector, double factor) {
    return test::table(samples, {"time,x,y,z", ",", 1e9, 1700000000000000000, {{vector, factor}}});
  };
  const auto logged = [&](const std::vector<RawSample>& gravity) {
    return read(file("parts.zip", test::zip({{"Accelerometer.csv", one(truth, &RawSample::acc_mps2, 0.01)},
                                             {"Gravity.csv", one(gravity, &RawSample::acc_mps2, 0.99)},
                                             {"Gyroscope.csv", one(truth, &RawSample::gyr_radps, 1.0)}})));
  };
  const auto summed = logged(truth);
  ASSERT_EQ(summed.recording.acc_mps2.size(), truth.size());
  EXPECT_NEAR(summed.recording.acc_mps2[7].y(), truth[7].acc_mps2[1], 1e-6);
  EXPECT_THAT(all(summed.reasons), HasSubstr("Accelerometer.csv + Gravity.csv: both have the same times"));
  const auto apart = logged(late);
  EXPECT_TRUE(apart.recording.acc_mps2.empty());
  EXPECT_THAT(all(apart.reasons), HasSubstr("no accelerometer: its gravity in Gravity.csv has other times"));
}

TEST(LeftOut, APresetOfAnotherKindOfFileIsRefusedByWhatTheFileIs) {
  const auto truth = test::hand();
  const auto refused = [](const std::string& path, const std::string& preset) {
    return test::refusal(path, {preset, std::nullopt, ""});
  };
  const auto plain = file("plain.csv", table_of(truth, "t,ax,ay,az,wx,wy,wz", 1.0));
  for (const char* preset : {"px4", "ros2", "kalibr"})
    EXPECT_THAT(refused(plain, preset),
                HasSubstr(fmt::format("not what --preset {} reads; it is a table with the columns t, ax", preset)));
  const auto flight = file("flight2.ulg", test::ulog(truth));
  for (const char* preset : {"ros2", "kalibr"}) EXPECT_THAT(refused(flight, preset), HasSubstr("(--preset px4)"));
  EXPECT_EQ(read(flight, {"px4", std::nullopt, ""}).recording.size(), truth.size());
}

TEST(LeftOut, FoldersInAFolderAreRead) {
  const auto truth = test::hand();
  const std::string folder = test::scratch("dataset");
  std::filesystem::create_directories(folder + "/mav0/imu0");
  std::filesystem::create_directories(folder + "/.git");
  const std::string text = table_of(truth, "time_s,ax,ay,az,gyr_x_radps,gyr_y_radps,gyr_z_radps", 1.0);
  std::ofstream(folder + "/mav0/imu0/data.csv") << text;
  std::ofstream(folder + "/.git/other.csv") << text;
  std::ofstream(folder + "/mav0/1.png") << "picture";
  const auto imported = read(folder);
  EXPECT_EQ(imported.recording.size(), truth.size());
  EXPECT_THAT(all(imported.reasons), Not(HasSubstr("other.csv")));
  EXPECT_THAT(all(imported.reasons), Not(HasSubstr("1.png")));
}

}  // namespace
}  // namespace stillpoint::exchange

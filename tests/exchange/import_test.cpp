#include "exchange/import.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "core/units.h"
#include "exchange/mcap_writer.h"
#include "tests/exchange/foreign_files.h"
#include "tests/exchange/importing.h"

namespace stillpoint::exchange {
namespace {

using test::all;
using test::file;
using test::read;
using test::refusal;
using test::Written;
using testing::HasSubstr;
constexpr double kG = 1.0 / kStandardGravity_mps2;

/// Float32 and nine digits of text leave that much.
void expect_same(const io::Recording& r, const std::vector<RawSample>& truth, double relative = 1e-6) {
  ASSERT_EQ(r.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_LE(std::abs(r.t_ns[i] - (truth[i].t_ns - truth[0].t_ns)), 1000) << "row " << i;
    ASSERT_LT((r.acc_mps2[i] - vec(truth[i].acc_mps2)).norm(), relative * 20.0) << "row " << i;
    ASSERT_LT((r.gyr_radps[i] - vec(truth[i].gyr_radps)).norm(), relative * 10.0) << "row " << i;
    if (!r.mag_uT.empty()) {
      ASSERT_LT((r.mag_uT[i] - vec(truth[i].mag_uT)).norm(), relative * 100.0) << "row " << i;
    }
  }
}

TEST(Import, EurocKeepsTheLastDigitsOfItsNanoseconds) {
  const auto truth = test::hand();
  const auto text = test::table(
      truth, {"#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y "
              "[m s^-2],a_RS_S_z [m s^-2]",
              ",",
              1e9,
              1403636579758555392,
              {{&RawSample::gyr_radps, 1.0}, {&RawSample::acc_mps2, 1.0}}});
  const auto imported = read(file("euroc.csv", text));
  expect_same(imported.recording, truth);
  for (std::size_t i = 0; i < truth.size(); ++i) ASSERT_EQ(imported.recording.t_ns[i], truth[i].t_ns - truth[0].t_ns);
  EXPECT_EQ(imported.recording.header.at("start_time_ns"), std::to_string(1403636579758555392 + truth[0].t_ns));
  EXPECT_THAT(all(imported.reasons), HasSubstr("EuRoC"));
}

TEST(Import, KalibrsColumnsAndCarriageReturns) {
  const auto truth = test::hand();
  std::string text = test::table(truth, {"timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z",
                                         ",",
                                         1e9,
                                         1500000000000000000,
                                         {{&RawSample::gyr_radps, 1.0}, {&RawSample::acc_mps2, 1.0}}});
  std::string dos;
  for (const char c : text) dos += c == '\n' ? "\r\n" : std::string(1, c);
  expect_same(read(file("imu0.csv", dos)).recording, truth);
}

TEST(Import, APhyphoxZipHasOneTableASensor) {
  const auto truth = test::hand();
  const auto one = [&](const std::string& unit, Array3 RawSample::*vector) {
    return test::table(
        truth, {fmt::format("\"Time (s)\",\"X ({0})\",\"Y ({0})\",\"Z ({0})\"", unit), ",", 1.0, 0, {{vector, 1.0}}});
  };
  const auto zip = test::zip({{"Accelerometer.csv", one("m/s^2", &RawSample::acc_mps2)},
                              {"Gyroscope.csv", one("rad/s", &RawSample::gyr_radps)},
                              {"Magnetometer.csv", one("\xC2\xB5T", &RawSample::mag_uT)},
                              {"meta/device.csv", "\"property\",\"value\"\n\"version\",\"1.1\"\n"},
                              {"__MACOSX/._Gyroscope.csv", "rubbish"}});
  const auto imported = read(file("phyphox.zip", zip));
  expect_same(imported.recording, truth);
  EXPECT_FALSE(imported.recording.mag_uT.empty());
}

TEST(Import, SensorLoggerInGIsFoundByItsNorm) {
  const auto truth = test::hand();
  const auto one = [&](Array3 RawSample::*vector, double factor) {
    return test::table(truth, {"time,x,y,z", ",", 1e9, 1700000000000000000, {{vector, factor}}});
  };
  const auto zip = test::zip({{"Accelerometer.csv", one(&RawSample::acc_mps2, 0.01)},
                              {"TotalAcceleration.csv", one(&RawSample::acc_mps2, kG)},
                              {"Gyroscope.csv", one(&RawSample::gyr_radps, 1.0)},
                              {"Metadata.csv", "version,device\n3,phone\n"}});
  const auto imported = read(file("logger.zip", zip));
  expect_same(imported.recording, truth);
  EXPECT_THAT(all(imported.reasons), HasSubstr("looks like g: median norm 1.00"));
}

TEST(Import, AndroSensorWithSemicolonsAndDecimalCommas) {
  const auto truth = test::hand();
  std::string text = test::table(truth, {"", ";", 1e3, 0, {{&RawSample::acc_mps2, 1.0}, {&RawSample::gyr_radps, 1.0}}});
  for (char& c : text)
    if (c == '.') c = ',';
  std::string header = "Time since start in ms";
  for (const char* name : {"ACCELEROMETER {} (m/s\xC2\xB2)", "GYROSCOPE {} (rad/s)"})
    for (const char* axis : {"X", "Y", "Z"}) header += ";" + fmt::format(fmt::runtime(name), axis);
  expect_same(read(file("andro.csv", header + text)).recording, truth);
}

struct Guess {
  const char* header;
  double time, acc, gyr, mag;
  const char* reason;
};
void PrintTo(const Guess& g, std::ostream* out) { *out << g.reason; }
class Guessed : public testing::TestWithParam<Guess> {};

TEST_P(Guessed, UnitsAreToldFromTheValues) {
  const Guess& g = GetParam();
  const auto truth = test::hand();
  const auto text = test::table(
      truth, {g.header,
              ",",
              g.time,
              0,
              {{&RawSample::acc_mps2, g.acc}, {&RawSample::gyr_radps, g.gyr}, {&RawSample::mag_uT, g.mag}}});
  const auto imported = read(file("guess.csv", text));
  expect_same(imported.recording, truth, 1e-5);
  EXPECT_FALSE(imported.recording.mag_uT.empty());
  EXPECT_THAT(all(imported.reasons), HasSubstr(g.reason));
}
INSTANTIATE_TEST_SUITE_P(
    Import, Guessed,
    testing::Values(Guess{"t,ax,ay,az,gx,gy,gz,mx,my,mz", 1.0, kG, kDegPerRad, 0.01, "gx, gy, gz looks like deg/s"},
                    Guess{"t,ax,ay,az,gx,gy,gz,mx,my,mz", 1.0, 1.0, 1.0, 1.0, "gx, gy, gz looks like rad/s"},
                    Guess{"time,accelX,accelY,accelZ,gyroX,gyroY,gyroZ,magX,magY,magZ", 1e3, 1e3 * kG, kDegPerRad, 10.0,
                          "looks like mg"},
                    Guess{"timestamp,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps,mag_x_nT,mag_y_nT,mag_z_nT",
                          1e6, kG, kDegPerRad, 1e3, "looks like us: 100 Hz"},
                    Guess{"%time,field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z,"
                          "field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,"
                          "field.magnetic_field.x,field.magnetic_field.y,field.magnetic_field.z",
                          1e9, 1.0, 1.0, 1e-6, "looks like T"}));

/// As recordings of ours are, where sensors have clocks of their own.
TEST(Import, ATableWithOneSensorARowIsReadWhicheverComesFirst) {
  const auto truth = test::hand();
  for (const char separator : {',', '\t'})
    for (const bool acc_first : {false, true}) {
      std::string text = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const bool acc = (i % 2 == 0) == acc_first;
        const auto& [x, y, z] = acc ? truth[i].acc_mps2 : truth[i].gyr_radps;
        text += fmt::format(fmt::runtime(acc ? "{},{},{},{},,,\n" : "{},,,,{},{},{}\n"), in_seconds(truth[i].t_ns), x,
                            y, z);
      }
      std::replace(text.begin(), text.end(), ',', separator);
      const auto& r = read(file("union.csv", text)).recording;
      ASSERT_EQ(r.size(), truth.size()) << "the last row is whole too";
      for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(r.acc_mps2[i].allFinite(), (i % 2 == 0) == acc_first);
    }
}

TEST(Import, AMapSaysColumnsUnitsAndMount) {
  const auto truth = test::hand();
  const auto data = file(
      "map.csv",
      test::table(
          truth, {"when,u,v,w,p,q,r", ",", 1e3, 0, {{&RawSample::acc_mps2, kG}, {&RawSample::gyr_radps, kDegPerRad}}}));
  const auto map = read_column_map(file("map.yaml",
                                        "time: {column: when, unit: ms}\nacc: {columns: [u, v, w], unit: g}\n"
                                        "gyr: {columns: [p, q, r], unit: deg/s}\nmount: \"+y -x +z\"\n"));
  ASSERT_TRUE(map) << map.error().message;
  const auto imported = read(data, {"", *map, ""});
  ASSERT_EQ(imported.recording.size(), truth.size());
  EXPECT_NEAR(imported.recording.acc_mps2[5].x(), truth[5].acc_mps2[1], 1e-5);
  EXPECT_NEAR(imported.recording.gyr_radps[5].y(), -truth[5].gyr_radps[0], 1e-5);
  EXPECT_THAT(all(imported.reasons), testing::Not(HasSubstr("WARNING"))) << "gravity against axes not turned yet";
}

TEST(Import, AFaultyMapIsNamedByLineAndColumn) {
  const auto said = [](const std::string& text) {
    const auto map = read_column_map(file("bad.yaml", text));
    return map ? std::string("accepted") : map.error().message;
  };
  EXPECT_THAT(said("acc: {colums: [a, b, c]}\n"), HasSubstr("did you mean 'columns'?"));
  EXPECT_THAT(said("acc: {columns: [a, b], unit: g}\n"), HasSubstr("three columns"));
  EXPECT_THAT(said("acc: {columns: [a, b, c], unit: furlong}\n"), HasSubstr("bad.yaml:1:33"));
  EXPECT_THAT(said("acc: {columns: [a, b, c]}\nmount: \"+x +y -z\"\n"), HasSubstr("right-handed"));
  EXPECT_THAT(said("time: {column: t, unit: h}\n"), HasSubstr("no unit of time"));
  EXPECT_THAT(said("time: t\n"), HasSubstr("no sensor"));
}

TEST(Import, PlainGzipIsUnpackedAndACutOneSaysSo) {
  const auto truth = test::hand();
  const std::string packed = test::deflated(
      test::table(
          truth,
          {"time_s,ax,ay,az,wx,wy,wz", ",", 1.0, 0, {{&RawSample::acc_mps2, 1.0}, {&RawSample::gyr_radps, 1.0}}}),
      31);
  expect_same(read(file("log.csv.gz", packed)).recording, truth);
  EXPECT_THAT(refusal(file("cut.csv.gz", packed.substr(0, packed.size() / 2))),
              HasSubstr("damaged or cut short after"));
}

TEST(Import, ADamagedZipIsRefusedByItsChecksum) {
  std::string zip = test::zip({{"a.csv", std::string(1000, 'x')}});
  zip[14] = static_cast<char>(zip[14] ^ 1);  // in the local header, which is not believed
  zip[zip.find("PK\x01\x02") + 16] ^= 1;
  EXPECT_THAT(refusal(file("bad.zip", zip)), HasSubstr("checksum"));
  EXPECT_THAT(refusal(file("cut.zip", zip.substr(0, 40))), HasSubstr("cut short"));
}

TEST(Import, Px4LogsAreTurnedToOurAxes) {
  const auto truth = test::hand();
  const std::string log = test::ulog(truth);
  const auto imported = read(file("flight.ulg", log));
  expect_same(imported.recording, truth, 1e-6);
  EXPECT_EQ(imported.recording.temp_degC.at(3), 31.5);
  EXPECT_THAT(all(imported.reasons), HasSubstr("forward-left-up"));
  const auto cut = read(file("cut.ulg", log.substr(0, log.size() / 2 + 7)));
  EXPECT_GT(cut.recording.size(), 900U);
  EXPECT_THAT(all(cut.reasons), HasSubstr("ends in the middle of a message"));
}

TEST(Import, AnMcapFileOfOursComesBackBitForBitAndWholeChunksSurviveACut) {
  const auto truth = test::hand();
  const std::string path = test::scratch("ours.mcap");
  auto writer = McapWriter::create(path);
  ASSERT_TRUE(writer);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    RawSample s = truth[i];
    if (i % 4 != 0) s.has = static_cast<std::uint8_t>(s.has & ~kMag);
    if (i == 7) s.has = static_cast<std::uint8_t>(s.has & ~kAcc);
    ASSERT_TRUE(writer->append(s));
  }
  ASSERT_TRUE(writer->finish());
  const auto& r = read(path).recording;
  ASSERT_EQ(r.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_EQ(array(r.gyr_radps[i]), truth[i].gyr_radps);
    ASSERT_EQ(r.acc_mps2[i].allFinite(), i != 7);
    ASSERT_EQ(r.mag_uT[i].allFinite(), i % 4 == 0);
  }
  EXPECT_NEAR(r.mag_uT[4].x(), truth[4].mag_uT[0], 1e-9);

  std::ifstream whole(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  const auto cut = read(file("cut.mcap", bytes.substr(0, bytes.size() / 2)));
  EXPECT_GT(cut.recording.size(), 800U);
  EXPECT_THAT(all(cut.reasons), HasSubstr("ends in the middle of a record"));
}

TEST(Import, AnMcapFileWithoutSensorsNamesItsTopics) {
  auto writer = McapWriter::create(test::scratch("empty.mcap"));
  ASSERT_TRUE(writer && writer->finish());
  EXPECT_THAT(refusal(test::scratch("empty.mcap")), HasSubstr("/imu/data_raw (sensor_msgs/msg/Imu)"));
}

TEST(Import, WhatCannotBeToldIsAskedFor) {
  const auto truth = test::hand();
  const auto still = std::vector<RawSample>(200, truth[0]);
  std::vector<RawSample> rest = still;
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i].t_ns = static_cast<std::int64_t>(i) * 10'000'000;
  EXPECT_THAT(
      refusal(
          file("rest.csv",
               test::table(
                   rest,
                   {"t,ax,ay,az,gx,gy,gz", ",", 1.0, 0, {{&RawSample::acc_mps2, 1.0}, {&RawSample::gyr_radps, 1.0}}}))),
      HasSubstr("the motion does not tell"));
  EXPECT_THAT(
      refusal(file("linear.csv", test::table(truth, {"t,ax,ay,az", ",", 1.0, 0, {{&RawSample::acc_mps2, 0.01}}}))),
      HasSubstr("gravity seems to be taken out"));
  EXPECT_THAT(refusal(file("notime.csv", "a,b,c\n1,2,3\n2,3,4\n")), HasSubstr("no column looks like the time"));
  EXPECT_THAT(refusal(file("binary.bin", std::string("\x01\x00\x02\x03", 4))), HasSubstr("no text"));
  EXPECT_THAT(refusal(file("ragged.csv", "t,ax,ay\n1,2,3\n1,2,3,4\n")), HasSubstr("ragged.csv:3: 4 fields"));
  EXPECT_THAT(refusal(file("bag.db3", "SQLite format 3")), HasSubstr("ros2 bag convert"));
  EXPECT_THAT(refusal("/nowhere/at/all.csv"), HasSubstr("/nowhere/at/all.csv"));
}

}  // namespace
}  // namespace stillpoint::exchange

#include "sources/line.h"

#include <gtest/gtest.h>

#include "core/units.h"

namespace stillpoint::sources {
namespace {

LineFormat with_header(const char* header) {
  LineFormat format({});
  EXPECT_TRUE(format.use_header(header)) << header;
  return format;
}

io::StreamParams columns(io::ColumnMap map) {
  io::StreamParams params;
  params.columns = std::move(map);
  return params;
}

TEST(Line, ColumnsOfAHeaderComeInSiUnits) {
  const auto format = with_header(
      "time_ms,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps,mag_x_gauss,"
      "mag_y_gauss,mag_z_gauss,temp_degC");
  Reading r;
  ASSERT_EQ(format.parse("12.5,0,0,1,180,0,-90,0.2,0,-0.4,31.5\r", r), Piece::kReading);
  EXPECT_EQ(r.sample.t_ns, 12'500'000);
  EXPECT_EQ(r.sample.has, kAcc | kGyr | kMag | kTemp);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[2], kStandardGravity_mps2);
  EXPECT_DOUBLE_EQ(r.sample.gyr_radps[0], 180 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(r.sample.mag_uT[2], -40.0);
  EXPECT_DOUBLE_EQ(r.sample.temp_degC, 31.5);
}

TEST(Line, NamesOfAHeaderMayStandInQuotesInCapitalsAndBehindAByteOrderMark) {
  for (const char* header :
       {"\xEF\xBB\xBFtime_ms,acc_x_g,acc_y_g,acc_z_g,mag_x_uT,mag_y_uT,mag_z_uT,temp_degC",
        R"("time_ms","acc_x_g","acc_y_g","acc_z_g","mag_x_uT","mag_y_uT","mag_z_uT","temp_degC")",
        "TIME_MS,ACC_X_G,ACC_Y_G,ACC_Z_G,MAG_X_UT,MAG_Y_UT,MAG_Z_UT,TEMP_DEGC",
        "\xEF\xBB\xBF\"Time_ms\"; \"Acc_X_g\"; \"Acc_Y_g\"; \"Acc_Z_g\"; Mag_X_T; Mag_Y_t; Mag_Z_T; Temp_degC"}) {
    Reading r;
    LineFormat format({});
    EXPECT_EQ(format.parse(header, r), Piece::kHeader) << header;
    ASSERT_TRUE(format.use_header(header)) << header;
    EXPECT_EQ(format.unknown_names(header), "");
    ASSERT_EQ(format.parse("12.5,0,0,1,20,0,-40,31.5", r), Piece::kReading) << header;
    EXPECT_EQ(r.sample.t_ns, 12'500'000);
    EXPECT_EQ(r.sample.has, kAcc | kMag | kTemp);
  }
}

TEST(Line, ARowMayHoldOneSensorAndATriadWithAMissingAxisIsNone) {
  const auto format = with_header("time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps");
  Reading r;
  ASSERT_EQ(format.parse("1,,,,0.1,0.2,0.3", r), Piece::kReading);
  EXPECT_EQ(r.sample.has, kGyr);
  ASSERT_EQ(format.parse("1,1,nan,3,0.1,0.2,0.3", r), Piece::kReading);
  EXPECT_EQ(r.sample.has, kGyr);
  EXPECT_EQ(format.parse("1,,,,,,", r), Piece::kIgnored);
}

TEST(Line, NamesThatAreNotKnownAreToldWithTheNearestThatIs) {
  LineFormat format({});
  EXPECT_EQ(format.unknown_names("time_ms,gyr_x_dps,accx_g,\"fan\""), "accx_g (acc_x_g?), \"fan\"");
  EXPECT_EQ(format.unknown_names(R"({"time_ms": 1, "acc_g": [0, 0, 1], "gyr": {"x": 1}})"), "gyr.x");
  EXPECT_EQ(LineFormat(columns({{"acc_x_g", "ax"}})).unknown_names("t,ax,ay"), "");
}

TEST(Line, HalfLinesGluedLinesAndGarbageAreMalformed) {
  const auto format = with_header("time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2");
  Reading r;
  for (const char* line : {"1,2,3", "1,2,3,4,5", "1,2,3,4x", "1,2,,3.4.5", "1,2,3,0x10", "1,2;3,4--", "\xff\xfe,1,2,3"})
    EXPECT_EQ(format.parse(line, r), Piece::kMalformed) << line;
  for (const char* line : {"", "  ", "# text", "\r"}) EXPECT_EQ(format.parse(line, r), Piece::kIgnored) << line;
}

TEST(Line, NumbersBeforeAnyHeaderAreNoReading) {
  Reading r;
  EXPECT_EQ(LineFormat({}).parse("1,2,3,4", r), Piece::kIgnored);
}

TEST(Line, TheConfigurationNamesColumnsByPositionOrByTheStreamsOwnName) {
  auto params = columns({{"time_us", "1"}, {"acc_x_counts", "2"}, {"acc_y_counts", "3"}, {"acc_z_counts", "4"}});
  params.acc_mps2_per_count = 0.001;
  Reading r;
  ASSERT_EQ(LineFormat(params).parse("5 9 -9 9807 what ever", r), Piece::kReading);
  EXPECT_EQ(r.sample.t_ns, 5000);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[2], 9.807);

  LineFormat named(columns({{"gyr_x_dps", "gx"}, {"gyr_y_dps", "gy"}, {"gyr_z_dps", "gz"}}));
  ASSERT_TRUE(named.use_header("t\tgz\tgy\tgx"));
  ASSERT_EQ(named.parse("0\t3\t2\t1", r), Piece::kReading);
  EXPECT_FALSE(r.has_time);
  EXPECT_DOUBLE_EQ(r.sample.gyr_radps[0], kRadPerDeg);
}

TEST(Line, JsonMayNameTheAxesInAnInnerObject) {
  LineFormat format({});
  Reading r;
  ASSERT_EQ(format.parse(R"({"acc_g": {"x": 0, "y": 0.5, "z": 1}})", r), Piece::kReading);
  EXPECT_EQ(r.sample.has, kAcc);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[1], 0.5 * kStandardGravity_mps2);
}

TEST(Line, NumbersMayStandInQuotes) {
  Reading r;
  ASSERT_EQ(LineFormat({}).parse(R"({"time_ns": "1500", "acc_g": ["0", "-5e-1", "1"], "device": "7b", "id": ""})", r),
            Piece::kReading);
  EXPECT_TRUE(r.has_time);
  EXPECT_EQ(r.sample.t_ns, 1500);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[1], -0.5 * kStandardGravity_mps2);
  LineFormat rows({});
  ASSERT_TRUE(rows.use_header(R"("acc_x_g","acc_y_g","acc_z_g")"));
  ASSERT_EQ(rows.parse(R"("0","0.5","1")", r), Piece::kReading);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[1], 0.5 * kStandardGravity_mps2);
}

TEST(Line, JsonHoldsReadingsFlatNestedOrInArrays) {
  Reading r;
  const LineFormat plain({});
  ASSERT_EQ(plain.parse(R"({"time_ns": 12, "acc_g": [0, 0, 1e0], "name": "a\"b", "ok": true, "n": null})", r),
            Piece::kReading);
  EXPECT_EQ(r.sample.t_ns, 12);
  EXPECT_DOUBLE_EQ(r.sample.acc_mps2[2], kStandardGravity_mps2);
  ASSERT_EQ(plain.parse(R"({"mag_x_uT":1,"mag_y_uT":2,"mag_z_uT":3})", r), Piece::kReading);
  EXPECT_EQ(r.sample.has, kMag);
  const LineFormat nested(
      columns({{"gyr_x_radps", "imu.w.x"}, {"gyr_y_radps", "imu.w.y"}, {"gyr_z_radps", "imu.w.z"}}));
  ASSERT_EQ(nested.parse(R"({"imu": {"w": {"x": 1, "y": 2, "z": 3}}})", r), Piece::kReading);
  EXPECT_EQ(r.sample.gyr_radps, (Array3{1, 2, 3}));
  for (const char* line : {"{", "{}x", R"({"a":})", R"({"a":1)", R"({"a" 1})", R"({"acc_g":[1,2})", "{{{{{{{{{{",
                           R"({"a":[[[[[[[[[[1]]]]]]]]]]})"})
    EXPECT_EQ(plain.parse(line, r), Piece::kMalformed) << line;
  EXPECT_EQ(plain.parse("{}", r), Piece::kIgnored);
}

TEST(Line, ARowAtATimeThatIsNoneIsRefusedWithThatTime) {
  const auto format = with_header("time_s,temp_degC,acc_x_mps2,acc_y_mps2,acc_z_mps2");
  Reading r;
  ASSERT_EQ(format.parse("1.7e18,20,0,0,9.8", r), Piece::kTimeRefused) << "ns since 1970 as seconds";
  EXPECT_DOUBLE_EQ(r.refused_time, 1.7e18);
  EXPECT_DOUBLE_EQ(r.time_unit_ns, 1e9);
  EXPECT_EQ(format.parse("-1.7e15,20,0,0,9.8", r), Piece::kTimeRefused);
  EXPECT_EQ(format.parse("1.7e18,,,,", r), Piece::kIgnored) << "no reading to refuse";
  ASSERT_EQ(format.parse("1.7e9,20,0,0,9.8", r), Piece::kReading);
  EXPECT_TRUE(r.has_time);
  ASSERT_EQ(format.parse(",20,0,0,9.8", r), Piece::kReading);
  EXPECT_FALSE(r.has_time);
  EXPECT_EQ(LineFormat({}).parse(R"({"time_us": 1.7e18, "acc_g": [0, 0, 1]})", r), Piece::kTimeRefused);
}

TEST(Line, AHeaderThatDoesNotFitTheConfigurationOrLacksAnAxisIsTold) {
  const auto faults = [](io::ColumnMap map, const char* header) {
    LineFormat format(columns(std::move(map)));
    format.use_header(header);
    return format.header_faults(header);
  };
  EXPECT_EQ(faults({}, "time_s,acc_x_g,acc_y_g,acc_z_g,temp_degC"), "");
  EXPECT_EQ(faults({}, "time_s,acc_x_g,acc_y_g,gyr_x_dps,gyr_y_dps,gyr_z_dps"),
            "the header line has no acc_z; without it nothing of acc_x/y/z_mps2 is used: send all three axes");
  const io::ColumnMap list{{"time_s", "1"}, {"gyr_x_dps", "2"}, {"gyr_y_dps", "3"}, {"gyr_z_dps", "4"}};
  EXPECT_EQ(faults(list, "time_s,gyr_x_dps,gyr_y_dps,gyr_z_dps,temp_degC"), "");
  EXPECT_EQ(faults(list, "t,x,y,z"), "");
  EXPECT_EQ(faults(list, "time_s,acc_x_g,acc_y_g,acc_z_g"),
            "column 2 is acc_x_g in the header line and another one in 'source: columns', which serves; correct the "
            "list, or leave it out");
  EXPECT_EQ(faults({{"gyr_x_dps", "gx"}, {"gyr_y_dps", "gy"}, {"gyr_z_dps", "gz"}}, "t,\"gy\",wx,wz"),
            "the header line lacks 'gx', 'gz' of 'source: columns'; write each as it stands there");
}

}  // namespace
}  // namespace stillpoint::sources

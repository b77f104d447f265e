#include "io/recording.h"

#include <gmock/gmock.h>

#include <cmath>

#include "io/recording_stream.h"
#include "io/yaml.h"
#include "tests/scratch_folder.h"

namespace stillpoint::io {
namespace {

constexpr const char* kHeader = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2\n";

TEST(Recording, ReadsColumnsByNameAndConvertsUnits) {
  const auto r =
      parse_recording("# sensor: abc\ntime_ms,gyr_z_dps,gyr_x_dps,gyr_y_dps,extra\n10,180,0,90,7\n", "f.csv");
  ASSERT_TRUE(r) << r.error().message;
  EXPECT_EQ(r->t_ns[0], 10'000'000);
  EXPECT_NEAR(r->gyr_radps[0].z(), 3.14159265358979, 1e-12);
  EXPECT_EQ(r->header.at("sensor"), "abc");
  EXPECT_THAT(r->issues.unknown_columns, ::testing::ElementsAre("extra"));
}

TEST(Recording, NamesLineAndColumnOfAMalformedField) {
  const auto r = parse_recording(std::string(kHeader) + "0,1,2,3\n1,1,x,3\n", "f.csv");
  ASSERT_FALSE(r);
  EXPECT_THAT(r.error().message, ::testing::StartsWith("f.csv:3:5: 'x' is not a number"));
}

TEST(Recording, RefusesTimesWhoseDifferenceNoClockCanCount) {
  const std::string header = "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2\n";
  for (const char* time : {"-9223372036854775808", "9223372036854775807", "4700000000000000000", "1e30", "-5e18"}) {
    const auto r = parse_recording(header + "0,1,2,3\n" + time + ",1,2,3\n", "f.csv");
    ASSERT_FALSE(r) << time;
    EXPECT_THAT(r.error().message, ::testing::StartsWith("f.csv:3:1: the time '" + std::string(time) + "'"));
  }
  const auto widest = parse_recording(header + "-4600000000000000000,1,2,3\n4600000000000000000,1,2,3\n", "f.csv");
  ASSERT_TRUE(widest) << widest.error().message;
  EXPECT_DOUBLE_EQ(widest->median_step_s(), 9.2e9);
}

TEST(Recording, AReadingThatItsUnitMakesInfiniteWasNotMeasured) {
  const auto r = parse_recording("time_s,mag_x_T,mag_y_T,mag_z_T\n0,1e305,0,0\n1,1e-5,0,0\n", "f.csv");
  ASSERT_TRUE(r) << r.error().message;
  EXPECT_EQ(r->issues.not_finite.first_line, 2U);
  EXPECT_TRUE(std::isnan(r->mag_uT[0].x()));
}

TEST(Recording, ADeviceOrAFolderIsNoFileToRead) {
  for (const char* path : {"/dev/zero", "/tmp"}) {
    EXPECT_EQ(read_recording(path).error().kind, ErrorKind::kNoInput) << path;
    EXPECT_EQ(load_yaml(path).error().kind, ErrorKind::kNoInput) << path;
  }
}

TEST(Recording, CountsWhatItDoesNotAccept) {
  const auto r = parse_recording(std::string(kHeader) +
                                     "0,1,2,3\n1,nan,2,3\n1,1,2,4\n0.5,1,2,3\n2,1,2,3\n3,1,2,3\n"
                                     "9,1,2,3\n10,1,2,3\n11,1",
                                 "f.csv");
  ASSERT_TRUE(r) << r.error().message;
  EXPECT_EQ(r->issues.not_finite.count, 1U);
  EXPECT_EQ(r->issues.repeated_time.first_line, 4U);
  EXPECT_EQ(r->issues.backward_time.first_line, 5U);
  EXPECT_EQ(r->issues.gap.count, 1U);
  EXPECT_DOUBLE_EQ(r->issues.longest_gap_s, 6.0);
  EXPECT_TRUE(r->issues.truncated_last_line);
  EXPECT_EQ(r->size(), 6U);
}

TEST(Recording, WhoseTimeRunsBackwardsIsNotOneRow) {
  const auto r = parse_recording(std::string(kHeader) + "3,1,2,3\n2,1,2,3\n1,1,2,3\n0,1,2,3\n", "f.csv");
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().kind, ErrorKind::kBadData);
  EXPECT_THAT(r.error().message, ::testing::StartsWith("f.csv:3: the time goes back, in 3 of 4 rows"));
}

TEST(Recording, JoinsRowsOfOneTimeThatCompleteEachOther) {
  const std::string header = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,mag_x_uT,mag_y_uT,mag_z_uT\n";
  const auto r =
      parse_recording(header + "0,1,2,3,,,\n0,,,,4,5,6\n1,,,,7,8,9\n1,1,2,3,,,\n1,1,2,3,,,\n1,,,,,,\n", "f.csv");
  ASSERT_TRUE(r) << r.error().message;
  ASSERT_EQ(r->size(), 2U);
  EXPECT_EQ(r->acc_mps2[0], Vec3(1, 2, 3));
  EXPECT_EQ(r->mag_uT[0], Vec3(4, 5, 6));
  EXPECT_EQ(r->acc_mps2[1], Vec3(1, 2, 3));
  EXPECT_EQ(r->mag_uT[1], Vec3(7, 8, 9));
  EXPECT_EQ(r->issues.repeated_time.count, 2U);  // what has nothing new is a repeated row as before
  EXPECT_EQ(r->issues.repeated_time.first_line, 6U);
}

TEST(Recording, ASensorsGapsAreJudgedByItsOwnRate) {
  // 200 Hz accelerometer, 50 Hz magnetometer, a reference at 7 Hz in rows of its own; one accelerometer reading missing
  // twice in a row, one magnetometer reading.
  std::string text = "time_ms,acc_x_mps2,acc_y_mps2,acc_z_mps2,mag_x_uT,mag_y_uT,mag_z_uT,ref_moving\n";
  for (int ms = 0; ms <= 1000; ++ms) {
    if (ms % 5 == 0 && ms != 405 && ms != 410) text += std::to_string(ms) + ",0,0,9.8,,,,\n";
    if (ms % 20 == 1 && ms != 601 && ms != 621) text += std::to_string(ms) + ",,,,20,0,-40,\n";
    if (ms % 143 == 3) text += std::to_string(ms) + ",,,,,,,1\n";
  }
  const auto r = parse_recording(text, "f.csv");
  ASSERT_TRUE(r) << r.error().message;
  EXPECT_EQ(r->issues.gap.count, 2U);
  EXPECT_DOUBLE_EQ(r->issues.longest_gap_s, 0.06);
  const auto times = sensor_times(*r);
  ASSERT_EQ(times.size(), 2U);
  EXPECT_STREQ(times[0].name, "acc");
  EXPECT_EQ(times[0].readings, 199U);
  EXPECT_DOUBLE_EQ(times[0].median_step_s, 0.005);
  EXPECT_DOUBLE_EQ(times[0].longest_gap_s, 0.015);
  EXPECT_DOUBLE_EQ(times[1].median_step_s, 0.02);
  EXPECT_EQ(times[1].gaps, 1U);
}

TEST(Recording, KeepsUserColumnsByNameAndTakesTextThereForNotMeasured) {
  const std::string text = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,rpm_hz,note,rpm_hz\n";
  const auto r = parse_recording(text + "0,1,2,3,50,start,1\n1,1,2,3,,x,1\n1,,,,70,,1\n", "f.csv");
  ASSERT_TRUE(r) << r.error().message;
  ASSERT_EQ(r->size(), 2U);
  EXPECT_THAT(r->user_columns.at("rpm_hz"), ::testing::ElementsAre(50.0, 70.0));
  EXPECT_TRUE(std::isnan(r->user_columns.at("note")[0]));
  EXPECT_THAT(r->issues.unknown_columns, ::testing::ElementsAre("rpm_hz", "note", "rpm_hz"));
  EXPECT_THAT(describe(r->issues),
              ::testing::ElementsAre("column 'rpm_hz' is not known, its numbers are kept under this name",
                                     "column 'note' is not known, its numbers are kept under this name",
                                     "column 'rpm_hz' is not known, set aside"));
}

TEST(Recording, NamesWhyAHeaderIsNotOne) {
  const auto why = [](std::string text) { return parse_recording(text + "\n0,1,2,3\n", "f.csv").error().message; };
  EXPECT_THAT(why("time_s;acc_x_mps2;acc_y_mps2;acc_z_mps2"), ::testing::HasSubstr("semicolons"));
  EXPECT_THAT(why("time_s\tacc_x_mps2\tacc_y_mps2\tacc_z_mps2"), ::testing::HasSubstr("tabs"));
  EXPECT_THAT(why("\"time_s\",\"acc_x_mps2\""), ::testing::HasSubstr("quotes"));
  EXPECT_THAT(why("Time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2"), ::testing::HasSubstr("has to be written 'time_s'"));
  EXPECT_THAT(why("time_s,acc_x,acc_y,acc_z"), ::testing::HasSubstr("'acc_x' lacks its unit, as in 'acc_x_mps2'"));
  EXPECT_THAT(why("0.01,9.8,0.1,0.2"), ::testing::HasSubstr("the first line holds numbers"));
  EXPECT_THAT(why(std::string("t\0i\0m\0", 6)), ::testing::HasSubstr("UTF-16"));
  EXPECT_THAT(why("time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2\r0,1,2,3"), ::testing::HasSubstr("carriage return"));
}

/// Differences of two times must fit their type: a century and a half on either side of nought is enough.
TEST(Recording, RefusesTimesWhoseDifferencesOverflow) {
  const auto r = parse_recording(
      "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2\n-9000000000000000000,1,2,3\n0,1,2,3\n"
      "9000000000000000000,1,2,3\n",
      "f.csv", OnMalformedRow::kCount);
  ASSERT_TRUE(r) << r.error().message;
  EXPECT_EQ(r->size(), 1U);
  EXPECT_EQ(r->issues.malformed.count, 2U);
}

TEST(Recording, EveryColumnIsWrittenAndReadBackInItsPlace) {
  Recording r;
  r.header = {{"sensor", "abc"}};
  for (int i = 0; i < 3; ++i) {
    r.t_ns.push_back(10'000'000 * i);
    r.acc_mps2.emplace_back(1 + i, 2, 3);
    r.gyr_radps.emplace_back(0.1, 0.2 + i, 0.3);
    r.mag_uT.emplace_back(10, 20, 30 + i);
    r.temp_degC.push_back(25.5 + i);
    r.current_A.push_back(0.5 * i);
    r.supply_V.push_back(3.5 - 0.5 * i);
    r.ref_q_world_body.emplace_back(0.5, 0.5, -0.5, 0.5);
    r.ref_position_m.emplace_back(-1, -2 - i, -3);
    r.ref_moving.push_back(i % 2);
    r.user_columns["wheel_rpm"].push_back(100 + i);
  }
  const test::ScratchFolder folder;
  const std::string path = folder / "every_column.csv";
  ASSERT_TRUE(write_recording(r, path));
  const auto back = read_recording(path);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->header.at("sensor"), "abc");
  EXPECT_EQ(back->t_ns, r.t_ns);
  EXPECT_EQ(back->acc_mps2, r.acc_mps2);
  EXPECT_EQ(back->gyr_radps, r.gyr_radps);
  EXPECT_EQ(back->mag_uT, r.mag_uT);
  EXPECT_EQ(back->temp_degC, r.temp_degC);
  EXPECT_EQ(back->current_A, r.current_A);
  EXPECT_EQ(back->supply_V, r.supply_V);
  EXPECT_EQ(back->ref_q_world_body, r.ref_q_world_body);
  EXPECT_EQ(back->ref_position_m, r.ref_position_m);
  EXPECT_EQ(back->ref_moving, r.ref_moving);
  EXPECT_EQ(back->user_columns, r.user_columns);
}

TEST(Recording, WhatIsWrittenRowByRowReadsBackWithWhatEachRowHolds) {
  const test::ScratchFolder folder;
  const std::string path = folder / "rows.csv";
  const RawSample all{5, 0, {1, 2, 3}, {4, 5, 6}, {7, 8, 9}, 30.25, kAcc | kGyr | kMag | kTemp};
  RawSample some = all;
  some.t_ns = 10'000'005;
  some.has = kGyr;
  {
    auto stream = RecordingStream::create(path, {{"sensor", "abc"}});
    ASSERT_TRUE(stream) << stream.error().message;
    ASSERT_TRUE(stream->append(all));
    ASSERT_TRUE(stream->append(some));
    EXPECT_EQ(stream->rows(), 2U);
    ASSERT_TRUE(stream->flush());
  }
  const auto back = read_recording(path);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->header.at("sensor"), "abc");
  ASSERT_EQ(back->size(), 2U);
  for (const auto& [row, wanted] : {std::pair{std::size_t{0}, all}, {std::size_t{1}, some}}) {
    const RawSample got = back->sample(row);
    EXPECT_EQ(got.t_ns, wanted.t_ns);
    EXPECT_EQ(got.has, wanted.has);
    EXPECT_EQ(got.gyr_radps, wanted.gyr_radps);
    if (wanted.holds(kAcc)) {
      EXPECT_EQ(got.acc_mps2, wanted.acc_mps2);
      EXPECT_EQ(got.mag_uT, wanted.mag_uT);
      EXPECT_EQ(got.temp_degC, wanted.temp_degC);
    }
  }
}

}  // namespace
}  // namespace stillpoint::io

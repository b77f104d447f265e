#include "c_api/stillpoint.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <vector>

#include "c_api/settings.h"
#include "pipeline/stages.h"
#include "tests/pipeline/samples.h"

namespace stillpoint {
namespace {

using testing::HasSubstr;
using Handle = std::unique_ptr<stillpoint_imu, decltype(&stillpoint_destroy)>;

Handle create(const std::vector<stillpoint_setting>& settings = {}) {
  return {stillpoint_create(settings.data(), settings.size(), nullptr, 0), &stillpoint_destroy};
}

std::string why_not(const char* name, double value) {
  char error[200] = "";
  const stillpoint_setting setting{name, value};
  EXPECT_EQ(stillpoint_create(&setting, 1, error, sizeof error), nullptr);
  return error;
}

stillpoint_reading reading_of(const RawSample& s) {
  stillpoint_reading r{};
  r.t_ns = s.t_ns;
  std::copy(s.acc_mps2.begin(), s.acc_mps2.end(), r.acc_mps2);
  std::copy(s.gyr_radps.begin(), s.gyr_radps.end(), r.gyr_radps);
  std::copy(s.mag_uT.begin(), s.mag_uT.end(), r.mag_uT);
  r.temp_degC = s.temp_degC;
  r.has = s.has;
  return r;
}

stillpoint_attitude attitude_of(const Handle& imu, std::int64_t now_ns = INT64_MIN) {
  stillpoint_attitude a{};
  EXPECT_EQ(stillpoint_get_attitude(imu.get(), now_ns, &a, sizeof a), STILLPOINT_DONE);
  return a;
}

stillpoint_calibration calibration_of(const Handle& imu, int sensor) {
  stillpoint_calibration c{};
  EXPECT_EQ(stillpoint_get_calibration(imu.get(), sensor, &c, sizeof c), STILLPOINT_DONE);
  return c;
}

TEST(CInterface, GivesBitForBitWhatThePipelineGives) {
  const auto samples = test::hand_samples(60.0);
  calib::OnlineCalibrator calibrator({}, {});
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(pipeline::StagesParams{}, calibrator.snapshot());
  pipeline::Processed processed;
  const auto imu = create();
  for (const RawSample& sample : samples) {
    const auto reading = reading_of(sample);
    ASSERT_EQ(stillpoint_push(imu.get(), &reading), STILLPOINT_DONE);
    ASSERT_NE(stages.process(sample, processed, link), pipeline::StageStatus::kDrop);
  }
  const AttitudeMessage expected = to_message(processed);
  const stillpoint_attitude a = attitude_of(imu);
  EXPECT_EQ(a.q_world_body_wxyz[0], expected.q_world_body_xyzw[3]);
  EXPECT_EQ(a.q_world_body_wxyz[1], expected.q_world_body_xyzw[0]);
  EXPECT_EQ(a.orientation_covariance_rad2[8], expected.orientation_covariance_rad2[8]);
  EXPECT_EQ(a.sigma_rpy_rad[2], expected.sigma_rpy_rad[2]);
  EXPECT_EQ(a.calibration_version, expected.calibration_version);
  EXPECT_GT(a.calibration_version, 0U);
  EXPECT_EQ(calibration_of(imu, STILLPOINT_GYR).bias[0], stages.live().gyr.bias[0]);
}

TEST(CInterface, StartsInIgnoranceAndIsStaleWithoutReadings) {
  const auto imu = create({{"stale_after_s", 0.5}});
  EXPECT_EQ(attitude_of(imu).status, STILLPOINT_INITIALIZING);
  EXPECT_GT(attitude_of(imu).orientation_covariance_rad2[0], 1.0);
  for (const RawSample& sample : test::hand_samples(2.0)) {
    const auto reading = reading_of(sample);
    stillpoint_push(imu.get(), &reading);
  }
  const std::int64_t last_ns = attitude_of(imu).t_ns;
  EXPECT_EQ(attitude_of(imu, last_ns + 400'000'000).status, STILLPOINT_OK);
  EXPECT_EQ(attitude_of(imu, last_ns + 600'000'000).status, STILLPOINT_STALE);
}

TEST(CInterface, RefusesWhatCannotBeUsedAndKeepsTheLastAttitude) {
  const auto imu = create();
  stillpoint_reading r{};
  r.t_ns = 1;
  r.acc_mps2[2] = 9.8;
  r.has = STILLPOINT_ACC | STILLPOINT_GYR;
  EXPECT_EQ(stillpoint_push(imu.get(), &r), STILLPOINT_DONE);
  EXPECT_EQ(stillpoint_push(imu.get(), &r), STILLPOINT_REFUSED) << "its time does not advance";
  r.t_ns = 10'000'000;
  r.acc_mps2[0] = r.gyr_radps[0] = NAN;
  EXPECT_EQ(stillpoint_push(imu.get(), &r), STILLPOINT_REFUSED) << "nothing of it is finite";
  EXPECT_EQ(attitude_of(imu).t_ns, 1);
  EXPECT_EQ(stillpoint_push(nullptr, &r), STILLPOINT_BAD_CALL);
  EXPECT_EQ(stillpoint_push(imu.get(), nullptr), STILLPOINT_BAD_CALL);
  EXPECT_EQ(stillpoint_get_attitude(imu.get(), 0, nullptr, 8), STILLPOINT_BAD_CALL);
}

TEST(CInterface, SensorsAtTheirOwnTimesJoinTheGyroscopes) {
  const auto imu = create();
  stillpoint_reading r{};
  r.acc_mps2[2] = 9.8;
  int done = 0, given = 0;
  for (; given < 400; ++given) {
    r.t_ns = 5'000'000LL * given;
    r.has = given % 2 == 0 ? STILLPOINT_GYR : STILLPOINT_ACC;
    done += stillpoint_push(imu.get(), &r) == STILLPOINT_DONE ? 1 : 0;
  }
  EXPECT_GT(done, given - 4);
  EXPECT_EQ(attitude_of(imu).t_ns, 5'000'000LL * 398);
  EXPECT_EQ(attitude_of(imu).status, STILLPOINT_OK);
}

TEST(CInterface, AnOlderCallerWithASmallerStructGetsItsPartAndNoMore) {
  const auto imu = create();
  stillpoint_attitude a{};
  a.status = 77;
  EXPECT_EQ(stillpoint_get_attitude(imu.get(), 0, &a, offsetof(stillpoint_attitude, status)), STILLPOINT_DONE);
  EXPECT_EQ(a.q_world_body_wxyz[0], 1.0);
  EXPECT_EQ(a.status, 77U);
}

TEST(CInterface, TakesACalibrationAndRefusesOneThatIsNone) {
  const auto imu = create();
  auto c = calibration_of(imu, STILLPOINT_ACC);
  c.bias[0] = 0.25;
  ASSERT_EQ(stillpoint_set_calibration(imu.get(), STILLPOINT_ACC, &c, sizeof c), STILLPOINT_DONE);
  EXPECT_EQ(calibration_of(imu, STILLPOINT_ACC).bias[0], 0.25);
  auto mirrored = c;
  mirrored.matrix[0] = -1.0;
  EXPECT_EQ(stillpoint_set_calibration(imu.get(), STILLPOINT_ACC, &mirrored, sizeof c), STILLPOINT_BAD_CALL);
  c.bias[0] = NAN;
  EXPECT_EQ(stillpoint_set_calibration(imu.get(), STILLPOINT_ACC, &c, sizeof c), STILLPOINT_BAD_CALL);
  EXPECT_EQ(stillpoint_set_calibration(imu.get(), STILLPOINT_TEMP, &c, sizeof c), STILLPOINT_BAD_CALL);
  EXPECT_EQ(calibration_of(imu, STILLPOINT_ACC).bias[0], 0.25) << "what was refused changed it";
}

TEST(CInterface, WhatWasLearntSurvivesARestart) {
  const auto imu = create();
  for (const RawSample& sample : test::hand_samples(40.0)) {
    const auto reading = reading_of(sample);
    stillpoint_push(imu.get(), &reading);
  }
  std::vector<char> state(stillpoint_state_size());
  ASSERT_EQ(stillpoint_save_state(imu.get(), state.data(), state.size()), STILLPOINT_DONE);
  const auto next = create();
  ASSERT_EQ(stillpoint_restore_state(next.get(), state.data(), state.size()), STILLPOINT_DONE);
  EXPECT_EQ(calibration_of(next, STILLPOINT_GYR).status, STILLPOINT_CALIBRATION_OK);
  EXPECT_NEAR(calibration_of(next, STILLPOINT_GYR).bias[0], calibration_of(imu, STILLPOINT_GYR).bias[0], 5e-4)
      << "only what the stretch of rest under way had added may be missing";
  state[0] = static_cast<char>(state[0] + 1);
  EXPECT_EQ(stillpoint_restore_state(next.get(), state.data(), state.size()), STILLPOINT_BAD_CALL);
  EXPECT_EQ(stillpoint_restore_state(next.get(), state.data(), state.size() - 1), STILLPOINT_BAD_CALL);
}

TEST(CInterface, SaysWhichSettingWasMeantAndWhatItsRangeIs) {
  EXPECT_THAT(why_not("attitude.use_magnetomter", 0), HasSubstr("did you mean 'attitude.use_magnetometer'?"));
  EXPECT_THAT(why_not("attitude.use_magnetometer", 0.5), HasSubstr("0 or 1"));
  EXPECT_THAT(why_not("rest.window_s", 100), HasSubstr("0.2 ... 30"));
  EXPECT_THAT(why_not("rest.window_s", NAN), HasSubstr("rest.window_s"));
  EXPECT_THAT(why_not(nullptr, 0), HasSubstr("without a name"));
}

TEST(CInterface, EverySettingTakesItsOwnDefaultRange) {
  const auto names = c_api::setting_names();
  EXPECT_GT(names.size(), 60U);
  c_api::Settings settings;
  EXPECT_EQ(c_api::set(settings, "attitude.field_reference.norm_tolerance", 1e9).empty(), false);
  EXPECT_EQ(c_api::set(settings, "output.initial_heading_rad", 0.5), "");
  EXPECT_EQ(settings.stages.initial_heading_rad, 0.5);
}

}  // namespace
}  // namespace stillpoint

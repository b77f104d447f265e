#include "fusion/attitude_filter.h"

#include <gtest/gtest.h>

#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;

TEST(AttitudeFilter, FollowsAHandMotionAtEveryRate) {
  for (const double rate_hz : {10.0, 50.0, 285.7, 1000.0, 4000.0}) {
    MotionParams p;
    p.rate_hz = rate_hz;
    p.turn_radps = rate_hz < 20.0 ? 0.3 : 1.0;  // at 10 Hz faster turns change within one step
    RandomMotion motion(p, 7);
    AttitudeFilter filter;
    double worst_tilt = 0.0, worst = 0.0;
    const int n = static_cast<int>(40.0 * rate_hz);
    for (int i = 0; i < n; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(false), false);
      expect_valid(e);
      if (i < n / 4) continue;
      const Vec3 error = test::error_world(motion.q_world_body(), quat(e.q_world_body));
      worst_tilt = std::max(worst_tilt, tilt_rad(error));
      worst = std::max(worst, error.norm());
    }
    EXPECT_LT(worst_tilt * kDegPerRad, 5.0) << rate_hz << " Hz";
    EXPECT_LT(worst * kDegPerRad, 10.0) << rate_hz << " Hz";
  }
}

TEST(AttitudeFilter, LearnsTheGyroBiasAtRestAndIgnoresAMotionThatTheRestDetectorHasNotSeen) {
  RandomMotion motion({.gyr_bias_walk_radps_rtHz = 0.0}, 3);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 1000; ++i) e = filter.step(motion.next(true), true);
  const Vec3 at_rest = vec(e.gyro_bias_radps);
  EXPECT_LT((at_rest - motion.bias_radps()).norm(), 1e-3);
  for (int i = 0; i < 60; ++i) e = filter.step(motion.next(false), true);  // at_rest is late by 0.6 s
  EXPECT_LT((vec(e.gyro_bias_radps) - at_rest).norm(), 1e-3);
}

TEST(AttitudeFilter, KeepsAGivenHeadingWithoutAMagnetometerAndItsYawVarianceGrows) {
  AttitudeFilterParams params;
  params.use_magnetometer = false;
  AttitudeFilter filter(params);
  filter.reset(1.2);
  CalibratedSample s;
  s.has = kAcc | kGyr;
  s.acc_mps2 = {0, 0, kStandardGravity_mps2};
  double previous = 0.0;
  for (int minute = 0; minute < 5; ++minute) {
    AttitudeEstimate e;
    for (int i = 0; i < 6000; ++i) {
      s.t_ns += 10'000'000;
      e = filter.step(s, false);
    }
    EXPECT_NEAR(2.0 * std::atan2(e.q_world_body[3], e.q_world_body[0]), 1.2, 1e-6);
    EXPECT_GT(e.sigma_yaw_rad, previous);
    EXPECT_LT(e.sigma_roll_rad, 0.02);
    EXPECT_EQ(e.heading, HeadingReference::kRelative);
    previous = e.sigma_yaw_rad;
  }
}

TEST(AttitudeFilter, ACopyContinuesBitForBit) {
  RandomMotion motion({}, 9);
  AttitudeFilter first;
  for (int i = 0; i < 777; ++i) (void)first.step(motion.next(false), false);
  AttitudeFilter second = first;
  for (int i = 0; i < 500; ++i) {
    const CalibratedSample s = motion.next(i % 200 < 100);
    const AttitudeEstimate a = first.step(s, false), b = second.step(s, false);
    ASSERT_EQ(a.q_world_body, b.q_world_body);
    ASSERT_EQ(a.covariance_world_rad2, b.covariance_world_rad2);
  }
}

TEST(AttitudeFilter, APartThatIsNotHeldDoesNotMatter) {
  AttitudeFilter clean, dirty;
  RandomMotion motion({}, 10);
  for (int i = 0; i < 500; ++i) {
    CalibratedSample s = motion.next(false);
    s.has = i % 3 == 0 ? kGyr : kAcc | kGyr;
    CalibratedSample d = s;
    d.mag_uT = {NAN, 1e300, NAN};
    if (i % 3 == 0) d.acc_mps2 = {NAN, NAN, -1e300};
    d.temp_degC = NAN;
    ASSERT_EQ(clean.step(s, false).q_world_body, dirty.step(d, false).q_world_body);
  }
}

TEST(AttitudeFilter, PredictionTurnsTheAttitudeOnByTheRate) {
  AttitudeFilterParams params;
  params.use_magnetometer = false;
  AttitudeFilter plain(params);
  params.prediction_s = 0.01;
  AttitudeFilter predicting(params);
  CalibratedSample s;
  s.has = kAcc | kGyr;
  s.acc_mps2 = {0, 0, kStandardGravity_mps2};
  s.gyr_radps = {0, 0, 1.0};
  AttitudeEstimate a, b;
  for (int i = 0; i < 100; ++i) {
    s.t_ns += 10'000'000;
    a = plain.step(s, false);
    b = predicting.step(s, false);
  }
  EXPECT_NEAR(test::error_world(quat(b.q_world_body), quat(a.q_world_body)).z(), 0.01, 1e-6);
}

TEST(InNed, NorthIsXAndYawIsClockwise) {
  AttitudeEstimate enu;  // the body looks east, level: NED yaw is +90 degrees
  enu.covariance_world_rad2 = {1, 0, 0, 0, 2, 0, 0, 0, 3};
  enu.rate_body_radps = {1, 2, 3};
  const AttitudeEstimate ned = in_ned(enu);
  const Quat q = quat(ned.q_world_body);
  EXPECT_LT((q * Vec3::UnitX() - Vec3(0, 1, 0)).norm(), 1e-12);  // forward is east, the y axis of NED
  EXPECT_LT((q * Vec3::UnitZ() - Vec3(0, 0, 1)).norm(), 1e-12);  // down is down
  EXPECT_EQ(ned.covariance_world_rad2, (Array9{2, 0, 0, 0, 1, 0, 0, 0, 3}));
  EXPECT_EQ(ned.rate_body_radps, (Array3{1, -2, -3}));
}

}  // namespace
}  // namespace stillpoint::fusion

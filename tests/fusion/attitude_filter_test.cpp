#include "fusion/attitude_filter.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/fusion/random_motion.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;

double tilt_rad(const Vec3& error) { return error.head<2>().norm(); }

void expect_valid(const AttitudeEstimate& e) {
  ASSERT_NEAR(test::quat(e.q_world_body).norm(), 1.0, 1e-12);
  ASSERT_TRUE(mat(e.covariance_world_rad2).allFinite());
  ASSERT_GE(e.sigma_roll_rad, 0.0);
  ASSERT_GE(e.sigma_yaw_rad, 0.0);
  ASSERT_TRUE(vec(e.rate_body_radps).allFinite());
}

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
      const Vec3 error = test::error_world(motion.q_world_body(), test::quat(e.q_world_body));
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

TEST(AttitudeFilter, HeadsByTheMagnetometerWithDeclination) {
  AttitudeFilterParams params;
  params.declination_rad = 0.1;
  AttitudeFilter filter(params);
  RandomMotion motion({}, 5);
  AttitudeEstimate e;
  for (int i = 0; i < 500; ++i) e = filter.step(motion.next(true), true);
  // The motion's field points to its y axis, which is magnetic north: true north lies 0.1 rad counter-clockwise of it.
  const Vec3 error = test::error_world(motion.q_world_body(), test::quat(e.q_world_body));
  EXPECT_NEAR(error.z(), 0.1, 0.02);
  EXPECT_EQ(e.heading, HeadingReference::kMagnetic);
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

TEST(AttitudeFilter, DistrustsADisturbedFieldKeepsTheHeadingAndSaysSo) {
  RandomMotion motion({}, 11);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 3000; ++i) e = filter.step(motion.next(false), false);
  EXPECT_EQ(e.heading, HeadingReference::kMagnetic);
  for (int i = 0; i < 1000; ++i) {
    CalibratedSample s = motion.next(false);
    vec(s.mag_uT) += motion.q_world_body().conjugate() * Vec3(25.0, 0.0, 10.0);  // a magnet in the room
    e = filter.step(s, false);
  }
  EXPECT_EQ(e.heading, HeadingReference::kDisturbed);
  const Vec3 error = test::error_world(motion.q_world_body(), test::quat(e.q_world_body));
  EXPECT_LT(std::abs(error.z()) * kDegPerRad, 4.0);
}

TEST(AttitudeFilter, AcceptsAFieldThatStaysAndKeepsTheHeading) {
  RandomMotion motion({}, 12);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 7000; ++i) {
    CalibratedSample s = motion.next(false);
    if (i > 3000) vec(s.mag_uT) += motion.q_world_body().conjugate() * Vec3(12.0, 12.0, 10.0);
    e = filter.step(s, false);
  }
  EXPECT_EQ(e.heading, HeadingReference::kMagnetic);
  const Vec3 error = test::error_world(motion.q_world_body(), test::quat(e.q_world_body));
  EXPECT_LT(std::abs(error.z()) * kDegPerRad, 15.0);  // the field itself has turned by 23 degrees
}

TEST(AttitudeFilter, TakesOutHardIronFixedToTheSensor) {
  MotionParams p;
  p.hard_iron_uT = {4.0, -5.0, 3.0};
  const auto rms = [&p](double sd_uT) {
    AttitudeFilterParams params;
    params.hard_iron.sd_uT = sd_uT;
    AttitudeFilter filter(params);
    RandomMotion motion(p, 21);
    double sum = 0.0;
    for (int i = 0; i < 24000; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(false), false);
      const Vec3 error = test::error_world(motion.q_world_body(), test::quat(e.q_world_body));
      if (i >= 12000) sum += error.z() * error.z() / 12000.0;
    }
    return std::sqrt(sum) * kDegPerRad;
  };
  const double with = rms(10.0);
  EXPECT_LT(with, 2.0);
  EXPECT_LT(with, 0.8 * rms(0.0));
}

TEST(AttitudeFilter, AHeldMagnetometerReadingCountsOnce) {
  // GIVEN the same motion with the magnetometer at 10 Hz, once as empty fields, once held
  AttitudeFilter empty, held;
  RandomMotion motion({}, 4);
  Array3 last{};
  for (int i = 0; i < 2000; ++i) {
    CalibratedSample s = motion.next(false);
    if (i % 10 == 0) last = s.mag_uT;
    CalibratedSample without = s;
    if (i % 10 != 0) without.has = kAcc | kGyr, without.mag_uT = {NAN, NAN, NAN};
    s.mag_uT = last;
    // THEN both give the same bits
    ASSERT_EQ(empty.step(without, false).q_world_body, held.step(s, false).q_world_body);
  }
}

TEST(AttitudeFilter, RebaseLeavesTheCorrectedRateWhatItWas) {
  RandomMotion motion({.gyr_bias_walk_radps_rtHz = 0.0}, 8);
  CalibrationSnapshot from, to;
  to.gyr.bias = {0.004, -0.003, 0.002};
  to.gyr.matrix = {1.003, 0.001, 0, -0.002, 0.998, 0, 0.001, 0, 1.002};
  to.mag.bias = {5, -3, 2};
  const auto apply = [](const CalibrationSnapshot& c, CalibratedSample s) {
    s.gyr_radps = array(c.gyr.apply(s.gyr_radps, 25.0));
    s.mag_uT = array(c.mag.apply(s.mag_uT, 25.0));
    return s;
  };
  AttitudeFilter kept, changed;
  for (int i = 0; i < 3000; ++i) {
    const bool still = i < 1000;
    const CalibratedSample raw = motion.next(still);
    if (i == 2000) changed.rebase(from, to);
    const AttitudeEstimate a = kept.step(apply(from, raw), still);
    const AttitudeEstimate b = changed.step(apply(i < 2000 ? from : to, raw), still);
    ASSERT_LT((vec(a.rate_body_radps) - vec(b.rate_body_radps)).norm(), i == 2000 ? 1e-12 : 1e-3) << i;
    ASSERT_LT(test::error_world(test::quat(a.q_world_body), test::quat(b.q_world_body)).norm(), 0.02) << i;
    if (i == 2000) {  // the reading's covariance did not change: nothing was counted again
      for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(a.gyro_bias_sd_radps[k], b.gyro_bias_sd_radps[k], 1e-6);
    }
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

TEST(AttitudeFilter, ABadReadingLeavesAUnitQuaternionAGrowingCovarianceAndAStatus) {
  const double huge = std::numeric_limits<double>::max();
  for (const Array3& bad : {Array3{NAN, 0, 0}, Array3{huge, huge, huge}, Array3{INFINITY, 0, 0}, Array3{1e150, 0, 0}}) {
    RandomMotion motion({}, 13);
    AttitudeFilter filter;
    AttitudeEstimate before;
    for (int i = 0; i < 1000; ++i) before = filter.step(motion.next(false), false);
    AttitudeEstimate e;
    for (int i = 0; i < 300; ++i) {
      CalibratedSample s = motion.next(false);
      s.acc_mps2 = s.gyr_radps = s.mag_uT = bad;
      e = filter.step(s, false);
      expect_valid(e);
    }
    EXPECT_EQ(e.status, AttitudeStatus::kDegraded);
    EXPECT_GT(e.sigma_yaw_rad, 10.0 * before.sigma_yaw_rad);
    EXPECT_GT(e.sigma_roll_rad, 10.0 * before.sigma_roll_rad);
    for (int i = 0; i < 3000; ++i) e = filter.step(motion.next(false), false);  // and it comes back
    const Vec3 error = test::error_world(motion.q_world_body(), test::quat(e.q_world_body));
    EXPECT_LT(tilt_rad(error) * kDegPerRad, 5.0);
  }
}

TEST(AttitudeFilter, ZerosLargeStuckAndClippedReadingsLeaveItValid) {
  for (const double value : {0.0, 1.0, 1999.0, 999.0, -500.0}) {
    for (const std::uint8_t clipped : {std::uint8_t{0}, std::uint8_t{kAcc | kGyr | kMag}}) {
      AttitudeFilter filter;
      CalibratedSample s;
      s.has = kAcc | kGyr | kMag;
      s.clipped = clipped;
      s.acc_mps2 = s.gyr_radps = s.mag_uT = {value, -value, value};
      for (int i = 0; i < 3000; ++i) {
        s.t_ns += 5'000'000;
        expect_valid(filter.step(s, i % 2 == 0));
      }
    }
  }
}

TEST(AttitudeFilter, AStuckGyroscopeBesideALivingAccelerometerIsDegradedAndTheCovarianceGrows) {
  RandomMotion motion({}, 14);
  AttitudeFilter filter;
  AttitudeEstimate before, e;
  for (int i = 0; i < 1000; ++i) before = filter.step(motion.next(false), false);
  for (int i = 0; i < 400; ++i) {
    CalibratedSample s = motion.next(false);
    s.gyr_radps = {0.1, 0.2, -0.1};
    e = filter.step(s, false);
  }
  EXPECT_EQ(e.status, AttitudeStatus::kDegraded);
  EXPECT_GT(e.sigma_yaw_rad, 3.0 * before.sigma_yaw_rad);
}

TEST(AttitudeFilter, ASaturatedAxisAddsUncertaintyAboutThatAxis) {
  RandomMotion motion({}, 15);
  AttitudeFilter plain, told;
  AttitudeEstimate a, b;
  for (int i = 0; i < 1020; ++i) {
    CalibratedSample s = motion.next(i < 1000);
    s.has = kAcc | kGyr;
    if (i >= 1000) s.gyr_radps = {0.0, 0.0, 34.9};
    a = plain.step(s, false);
    if (i >= 1000) s.clipped = kGyr;
    b = told.step(s, false);
  }
  EXPECT_GT(b.sigma_yaw_rad, a.sigma_yaw_rad + 0.1);
  EXPECT_EQ(b.status, AttitudeStatus::kDegraded);
}

TEST(AttitudeFilter, RefusesATimeThatDoesNotAdvanceAndBridgesAGapHonestly) {
  RandomMotion motion({}, 16);
  AttitudeFilter filter;
  AttitudeEstimate before;
  CalibratedSample s;
  for (int i = 0; i < 1000; ++i) before = filter.step(s = motion.next(false), false);
  const AttitudeEstimate same = filter.step(s, false);
  EXPECT_EQ(same.status, AttitudeStatus::kRefused);
  EXPECT_EQ(same.q_world_body, before.q_world_body);
  s.t_ns -= 5;
  EXPECT_EQ(filter.step(s, false).status, AttitudeStatus::kRefused);
  s.t_ns += 60'000'000'000;
  const AttitudeEstimate after = filter.step(s, false);
  expect_valid(after);
  EXPECT_EQ(after.status, AttitudeStatus::kDegraded);
  EXPECT_GT(after.sigma_yaw_rad, 1.0);
}

TEST(AttitudeFilter, WaitsWithTheIdentityUntilItHasSeenGravity) {
  AttitudeFilter filter;
  CalibratedSample s;
  s.has = kGyr;
  const AttitudeEstimate e = filter.step(s, false);
  EXPECT_EQ(e.status, AttitudeStatus::kWaiting);
  EXPECT_GT(e.sigma_roll_rad, 3.0);
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
  EXPECT_NEAR(test::error_world(test::quat(b.q_world_body), test::quat(a.q_world_body)).z(), 0.01, 1e-6);
}

TEST(InNed, NorthIsXAndYawIsClockwise) {
  AttitudeEstimate enu;  // the body looks east, level: NED yaw is +90 degrees
  enu.covariance_world_rad2 = {1, 0, 0, 0, 2, 0, 0, 0, 3};
  enu.rate_body_radps = {1, 2, 3};
  const AttitudeEstimate ned = in_ned(enu);
  const Quat q = test::quat(ned.q_world_body);
  EXPECT_LT((q * Vec3::UnitX() - Vec3(0, 1, 0)).norm(), 1e-12);  // forward is east, the y axis of NED
  EXPECT_LT((q * Vec3::UnitZ() - Vec3(0, 0, 1)).norm(), 1e-12);  // down is down
  EXPECT_EQ(ned.covariance_world_rad2, (Array9{2, 0, 0, 0, 1, 0, 0, 0, 3}));
  EXPECT_EQ(ned.rate_body_radps, (Array3{1, -2, -3}));
}

}  // namespace
}  // namespace stillpoint::fusion

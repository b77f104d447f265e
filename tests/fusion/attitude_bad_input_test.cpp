/// What no reading, however broken, may do to the filter.
#include "fusion/attitude_filter.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;

TEST(AttitudeBadInput, ABadReadingLeavesAUnitQuaternionAGrowingCovarianceAndAStatus) {
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

TEST(AttitudeBadInput, ZerosLargeStuckAndClippedReadingsLeaveItValid) {
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

TEST(AttitudeBadInput, AStuckGyroscopeBesideALivingAccelerometerIsDegradedAndTheCovarianceGrows) {
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

TEST(AttitudeBadInput, ASaturatedAxisAddsUncertaintyAboutThatAxis) {
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

TEST(AttitudeBadInput, RefusesATimeThatDoesNotAdvanceAndBridgesAGapHonestly) {
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

TEST(AttitudeBadInput, WaitsWithTheIdentityUntilItHasSeenGravity) {
  AttitudeFilter filter;
  CalibratedSample s;
  s.has = kGyr;
  const AttitudeEstimate e = filter.step(s, false);
  EXPECT_EQ(e.status, AttitudeStatus::kWaiting);
  EXPECT_GT(e.sigma_roll_rad, 3.0);
}

}  // namespace
}  // namespace stillpoint::fusion

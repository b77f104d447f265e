/// What no reading, however broken, may do to the filter.
#include "fusion/attitude_filter.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

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
    EXPECT_GT(e.sigma_yaw_rad, std::min(2.0, 10.0 * before.sigma_yaw_rad));
    EXPECT_GT(e.sigma_roll_rad, 10.0 * before.sigma_roll_rad);
    for (int i = 0; i < 3000; ++i) e = filter.step(motion.next(false), false);  // and it comes back
    const Vec3 error = test::error_world(motion.q_world_body(), quat(e.q_world_body));
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

TEST(AttitudeBadInput, AClippedBlowLeavesTheSpeedAlongItsAxisUnknown) {
  // GIVEN a level body that looks north, so that its x axis is the world's y
  AttitudeFilterParams params;
  params.use_magnetometer = false;
  params.update_period_s = 1e-3;  // the covariance is that of this very sample
  AttitudeFilter plain(params), told(params);
  plain.reset(std::numbers::pi / 2);
  told.reset(std::numbers::pi / 2);
  CalibratedSample s;
  s.has = kAcc | kGyr;
  AttitudeEstimate a, b;
  for (int i = 0; i < 1000; ++i) {
    s.t_ns += 10'000'000;
    s.acc_mps2 = {1e-3 * (i % 3), 0.0, kStandardGravity_mps2};
    s.gyr_radps = {0.0, 1e-5 * (i % 3), 0.0};
    // WHEN two readings lie at the rail of -x
    const bool blow = i >= 998;
    if (blow) s.acc_mps2[0] = -156.0;
    s.clipped = 0;
    a = plain.step(s, false);
    if (blow) s.clipped = kAcc;
    b = told.step(s, false);
  }
  // THEN what was cut off, half as much again over a tenth of a second, is in the speed along that axis and no other
  const auto more = [&](int axis) {
    return told.error_state().P()(kVelocity + axis, kVelocity + axis) -
           plain.error_state().P()(kVelocity + axis, kVelocity + axis);
  };
  EXPECT_EQ(a.status, AttitudeStatus::kOk);
  EXPECT_EQ(b.status, AttitudeStatus::kDegraded);
  // 78 m/s^2 for 0.1 s: a density of 608 m^2/s^3 over 0.02 s, of which the bounds of the motion take a part.
  EXPECT_GT(more(1), 7.0);
  EXPECT_LT(more(1), 14.0);
  EXPECT_LT(std::abs(more(0)), 0.02 * more(1));
  EXPECT_LT(std::abs(more(2)), 0.02 * more(1));
}

TEST(AttitudeBadInput, AStuckAccelerometerBesideALivingGyroscopeIsDegradedAndTheSpeedIsUnknown) {
  // The last bit alone tells the two apart.
  RandomMotion motion({}, 14);
  AttitudeFilter lives, stuck;
  AttitudeEstimate a, b;
  Array3 last{};
  for (int i = 0; i < 1400; ++i) {
    CalibratedSample s = motion.next(false);
    s.has = kAcc | kGyr;  // the field would deny either
    if (i < 1000) last = s.acc_mps2;
    s.acc_mps2 = last;
    if (i >= 1000 && i % 2 == 0) s.acc_mps2[0] += 1e-9;
    a = lives.step(s, false);
    s.acc_mps2 = last;
    b = stuck.step(s, false);
    if (i == 1090) {
      EXPECT_EQ(b.status, AttitudeStatus::kOk) << "nine tenths of a second may be chance";
    }
  }
  EXPECT_EQ(a.status, AttitudeStatus::kOk);
  EXPECT_EQ(b.status, AttitudeStatus::kDegraded);
  const auto speed_variance = [](const AttitudeFilter& f) { return f.error_state().P()(kVelocity, kVelocity); };
  EXPECT_GT(speed_variance(stuck), 2.0 * speed_variance(lives));
}

TEST(AttitudeBadInput, WhereNeitherSensorHasNoiseAnUnchangedReadingIsSound) {
  AttitudeFilter filter;
  CalibratedSample s;
  s.has = kAcc | kGyr;
  s.acc_mps2 = {0.0, 0.0, kStandardGravity_mps2};
  AttitudeEstimate e;
  for (int i = 0; i < 500; ++i) {
    s.t_ns += 10'000'000;
    e = filter.step(s, true);
  }
  EXPECT_EQ(e.status, AttitudeStatus::kOk);
}

TEST(AttitudeBadInput, RefusesATimeThatDoesNotAdvanceAndBridgesAGapHonestly) {
  RandomMotion motion({}, 16);
  AttitudeFilter filter;
  AttitudeEstimate before;
  CalibratedSample s;
  for (int i = 0; i < 1000; ++i) before = filter.step(s = motion.next(false), false);
  const AttitudeEstimate same = filter.step(s, false);
  EXPECT_TRUE(same.refused);
  EXPECT_EQ(same.q_world_body, before.q_world_body);
  s.t_ns -= 5;
  EXPECT_TRUE(filter.step(s, false).refused);
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
  EXPECT_EQ(e.status, AttitudeStatus::kInitializing);
  EXPECT_GT(e.sigma_roll_rad, 3.0);
}

}  // namespace
}  // namespace stillpoint::fusion

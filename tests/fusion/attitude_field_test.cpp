/// The filter and the magnetic field: heading, disturbance, iron on the body, a new calibration.
#include "fusion/attitude_filter.h"

#include <gtest/gtest.h>

#include "tests/fusion/random_motion.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;

TEST(AttitudeField, HeadsByTheMagnetometerWithDeclination) {
  AttitudeFilterParams params;
  params.declination_rad = 0.1;
  AttitudeFilter filter(params);
  RandomMotion motion({}, 5);
  AttitudeEstimate e;
  for (int i = 0; i < 500; ++i) e = filter.step(motion.next(true), true);
  // The motion's field points to its y axis, which is magnetic north: true north lies 0.1 rad counter-clockwise of it.
  const Vec3 error = test::error_world(motion.q_world_body(), quat(e.q_world_body));
  EXPECT_NEAR(error.z(), 0.1, 0.03);  // the first reading is off by 0.3 of 16 uT
  EXPECT_EQ(e.heading, HeadingReference::kTrue);
}

TEST(AttitudeField, DistrustsADisturbedFieldKeepsTheHeadingAndSaysSo) {
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
  const Vec3 error = test::error_world(motion.q_world_body(), quat(e.q_world_body));
  EXPECT_LT(std::abs(error.z()) * kDegPerRad, 4.0);
}

/// At rest nothing turns the heading, and yet nothing confirms it.
TEST(AttitudeField, AMagnetPutBesideABodyAtRestIsSaidAfterTwoSeconds) {
  RandomMotion motion({}, 11);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 3000; ++i) e = filter.step(motion.next(false), false);
  for (int i = 0; i < 400; ++i) e = filter.step(motion.next(true), true);
  EXPECT_EQ(e.heading, HeadingReference::kMagnetic);
  for (const bool late : {false, true}) {
    for (int i = 0; i < 150; ++i) {  // 1.5 s
      CalibratedSample s = motion.next(true);
      vec(s.mag_uT) += motion.q_world_body().conjugate() * Vec3(25.0, 0.0, 10.0);
      e = filter.step(s, true);
    }
    EXPECT_EQ(e.heading, late ? HeadingReference::kDisturbed : HeadingReference::kMagnetic);
  }
}

TEST(AttitudeField, AcceptsAFieldThatStaysAndKeepsTheHeading) {
  RandomMotion motion({}, 12);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 7000; ++i) {
    CalibratedSample s = motion.next(false);
    if (i > 3000) vec(s.mag_uT) += motion.q_world_body().conjugate() * Vec3(12.0, 12.0, 10.0);
    e = filter.step(s, false);
  }
  EXPECT_EQ(e.heading, HeadingReference::kMagnetic);
  const Vec3 error = test::error_world(motion.q_world_body(), quat(e.q_world_body));
  EXPECT_LT(std::abs(error.z()) * kDegPerRad, 15.0);  // the field itself has turned by 23 degrees
}

TEST(AttitudeField, TakesOutHardIronFixedToTheSensor) {
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
      const Vec3 error = test::error_world(motion.q_world_body(), quat(e.q_world_body));
      if (i >= 12000) sum += error.z() * error.z() / 12000.0;
    }
    return std::sqrt(sum) * kDegPerRad;
  };
  const double with = rms(10.0);
  EXPECT_LT(with, 2.0);
  EXPECT_LT(with, 0.8 * rms(0.0));
}

TEST(AttitudeField, AHeldMagnetometerReadingCountsOnce) {
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

TEST(AttitudeField, RebaseLeavesTheCorrectedRateWhatItWas) {
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
    ASSERT_LT(test::error_world(quat(a.q_world_body), quat(b.q_world_body)).norm(), 0.02) << i;
    if (i == 2000) {  // the reading's covariance did not change: nothing was counted again
      for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(a.gyro_bias_sd_radps[k], b.gyro_bias_sd_radps[k], 1e-6);
    }
  }
}

TEST(AttitudeField, TheYawVarianceHoldsTheIronThatIsNotYetKnown) {
  // GIVEN a sensor that has not turned yet: a few uT on the body would turn its heading, and nobody can know
  RandomMotion motion({}, 5);
  AttitudeFilterParams without_iron;
  without_iron.hard_iron.sd_uT = 0.0;
  AttitudeFilter filter, sure(without_iron);
  AttitudeEstimate e, known;
  const auto step = [&](bool still) {
    const CalibratedSample s = motion.next(still);
    e = filter.step(s, still);
    known = sure.step(s, still);
  };
  for (int i = 0; i < 500; ++i) step(true);
  EXPECT_GT(e.sigma_yaw_rad, 0.3);  // 10 uT across a horizontal field of 16
  EXPECT_LT(known.sigma_yaw_rad, 0.15);
  // WHEN it has turned about THEN what is left is small beside the rest
  for (int i = 0; i < 12000; ++i) step(false);
  EXPECT_LT(e.sigma_yaw_rad, 1.5 * known.sigma_yaw_rad);
}

TEST(AttitudeField, ACalibrationThatKnowsTheOffsetBetterTakesOverAndOneThatDoesNotLeavesTheHeading) {
  MotionParams p;
  p.hard_iron_uT = {4.0, -5.0, 3.0};
  const auto heading_after = [&p](double sd_uT, double scale) {
    CalibrationSnapshot from, to;
    to.mag.status = CalibrationStatus::kOk;
    to.mag.bias = array(p.hard_iron_uT);
    to.mag.matrix = array(Mat3(scale * Mat3::Identity()));
    to.mag.bias_covariance = array(Mat3(sd_uT * sd_uT * Mat3::Identity()));
    AttitudeFilter filter;
    RandomMotion motion(p, 21);
    AttitudeEstimate e;
    double sum = 0.0;
    for (int i = 0; i < 12000; ++i) {
      CalibratedSample s = motion.next(false);
      if (i == 3000) filter.rebase(from, to);
      s.mag_uT = array((i < 3000 ? from : to).mag.apply(s.mag_uT, 25.0));
      e = filter.step(s, false);
      const double error = test::error_world(motion.q_world_body(), quat(e.q_world_body)).z();
      if (i >= 9000) sum += error * error / 3000.0;
    }
    EXPECT_EQ(e.heading, HeadingReference::kMagnetic) << sd_uT << " uT, scale " << scale;
    return std::sqrt(sum) * kDegPerRad;
  };
  const double by_calibration = heading_after(0.1, 1.0), by_filter = heading_after(50.0, 1.0);
  EXPECT_LT(by_calibration, 2.0);
  EXPECT_LE(by_calibration, by_filter + 0.1);
  EXPECT_LT(heading_after(0.1, 1.3), 2.0);
}

/// However long it lies there: the place's deviation is one.
TEST(AttitudeField, WhatLiesStillIsToldOfOneDeviationOfThePlace) {
  RandomMotion motion({}, 4);
  AttitudeFilter filter;
  const auto lies_for = [&](int samples) {
    AttitudeEstimate e;
    for (int i = 0; i < samples; ++i) e = filter.step(motion.next(true), true);
    return e.sigma_yaw_rad;
  };
  const double early = lies_for(30 * 100), late = lies_for(300 * 100);
  EXPECT_LE(late, early);
  EXPECT_GT(late, 0.85 * early);
}

}  // namespace
}  // namespace stillpoint::fusion

/// What cannot be known is stated: pauses, the first heading, iron that nobody has calibrated.
#include <algorithm>

#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;

Vec3 error_of(const RandomMotion& motion, const AttitudeEstimate& e) {
  return test::error_world(motion.q_world_body(), quat(e.q_world_body));
}

TEST(AttitudeHonesty, APauseOfAFastTurnIsBridgedAndItsErrorStated) {
  MotionParams fast;
  fast.turn_radps = 5.0;
  fast.turn_time_s = 0.5;
  for (const int lost : {5, 30, 200}) {
    Coverage coverage;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      RandomMotion motion(fast, seed);
      AttitudeFilter filter;
      AttitudeEstimate e;
      for (int i = 0; i < 2000; ++i) e = filter.step(motion.next(i < 500), i < 500);
      for (int i = 0; i < lost; ++i) motion.next(false);
      for (int i = 0; i < 100; ++i) {
        e = filter.step(motion.next(false), false);
        const Vec3 error = error_of(motion, e);
        coverage.note(std::abs(error.x()) < 3.0 * std::sqrt(e.covariance_world_rad2[0]) &&
                      std::abs(error.y()) < 3.0 * std::sqrt(e.covariance_world_rad2[4]) &&
                      std::abs(error.z()) < 3.0 * e.sigma_yaw_rad);
      }
    }
    EXPECT_GT(coverage.share(), 0.95) << lost << " samples lost";
  }
}

/// A heading taken from the field while the tilt is far off is another one, and was stated within five degrees.
TEST(AttitudeHonesty, AfterAPauseTheHeadingWaitsForTheTilt) {
  MotionParams fast;
  fast.turn_radps = 8.0;
  fast.turn_time_s = 0.3;
  fast.speed_mps = 2.0;
  fast.speed_time_s = 0.3;
  Coverage coverage;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomMotion motion(fast, seed);
    AttitudeFilter filter;
    for (int i = 0; i < 2000; ++i) (void)filter.step(motion.next(i < 500), i < 500);
    for (int i = 0; i < 30; ++i) motion.next(false);
    for (int i = 0; i < 500; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(false), false);
      coverage.note(std::abs(error_of(motion, e).z()) < 3.0 * e.sigma_yaw_rad);
    }
  }
  EXPECT_GT(coverage.share(), 0.98);
}

/// Twenty seconds without a gyroscope, in strong motion: nobody knows which side is up, and the heading knows no more.
TEST(AttitudeHonesty, WithoutAGyroscopeTheHeadingIsNoSurerThanTheTilt) {
  MotionParams strong;
  strong.turn_radps = 3.0;
  strong.speed_mps = 1.0;
  strong.speed_time_s = 0.3;
  Coverage coverage;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    RandomMotion motion(strong, seed);
    AttitudeFilter filter;
    for (int i = 0; i < 5000; ++i) {
      CalibratedSample s = motion.next(i < 500);
      const bool silent = i >= 2000 && i < 4000;
      if (silent) s.has = static_cast<std::uint8_t>(s.has & ~kGyr);
      const AttitudeEstimate e = filter.step(s, i < 500);
      if (i < 2000) continue;
      coverage.note(std::abs(error_of(motion, e).z()) < 3.0 * e.sigma_yaw_rad);
    }
  }
  EXPECT_GT(coverage.share(), 0.97);
}

/// Iron three times as large as what a calibrated magnetometer has left, and no turn that could show it.
TEST(AttitudeHonesty, WhoGoesStraightOnDoesNotKnowTheIronOnHim) {
  MotionParams straight;
  straight.turn_radps = 0.02;
  straight.hard_iron_uT = Vec3(30.0, -9.0, 5.0);
  Coverage coverage;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomMotion motion(straight, seed);
    AttitudeFilter filter;
    for (int i = 0; i < 3000; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(false), false);
      if (i < 500) continue;
      coverage.note(std::abs(error_of(motion, e).z()) < 3.0 * e.sigma_yaw_rad);
    }
  }
  EXPECT_GT(coverage.share(), 0.98);
}

/// What a lever arm adds to the force while a body circles is constant in it, and gone when it stops.
TEST(AttitudeHonesty, AnOffsetOfTheAccelerometerFarOutsideOfItsPriorIsNotKeptAsKnown) {
  Coverage coverage;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    RandomMotion motion({}, seed);
    AttitudeFilter filter;
    for (int i = 0; i < 9000; ++i) {
      CalibratedSample s = motion.next(i >= 6000);
      if (i < 6000) s.acc_mps2[0] += 1.0;
      const AttitudeEstimate e = filter.step(s, i >= 6000);
      if (i < 6300) continue;
      coverage.note(tilt_rad(error_of(motion, e)) < 3.4 * std::hypot(e.sigma_roll_rad, e.sigma_pitch_rad));
    }
  }
  EXPECT_GT(coverage.share(), 0.98);
}

TEST(AttitudeHonesty, AfterALongPauseItIsDegradedUntilTheTiltIsKnownAgain) {
  RandomMotion motion({}, 3);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 1000; ++i) e = filter.step(motion.next(i < 500), i < 500);
  EXPECT_EQ(e.status, AttitudeStatus::kOk);
  for (int i = 0; i < 300; ++i) motion.next(false);
  e = filter.step(motion.next(false), false);
  EXPECT_EQ(e.status, AttitudeStatus::kDegraded);
  EXPECT_GT(e.sigma_roll_rad, 0.05);
  for (int i = 0; i < 2000; ++i) e = filter.step(motion.next(i < 1000), i < 1000);
  EXPECT_EQ(e.status, AttitudeStatus::kOk);
  EXPECT_LT(tilt_rad(error_of(motion, e)) * kDegPerRad, 2.0);
}

TEST(AttitudeHonesty, TheHeadingIsStatedFromTheFirstSampleOn) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomMotion motion({}, seed);
    AttitudeFilter filter;
    for (int i = 0; i < 100; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(false), false);
      EXPECT_LT(std::abs(error_of(motion, e).z()), 3.0 * e.sigma_yaw_rad) << "seed " << seed << ", sample " << i;
    }
  }
}

/// A program that resampled a log bridged five seconds without a gyroscope by a straight line, to five decimals.
TEST(AttitudeHonesty, RatesThatAreDrawnAsALineAreNoReadings) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    RandomMotion motion({}, seed);
    AttitudeFilter filter;
    int outside = 0, ok = 0;
    for (int i = 0; i < 3000; ++i) {
      CalibratedSample s = motion.next(i < 500);
      const bool drawn = i >= 2000 && i < 2500;
      const double way = (i - 2000) / 500.0;
      for (double& x : s.gyr_radps)
        if (drawn) x = 1e-5 * std::round(1e5 * (0.4 - 0.9 * way));
      const AttitudeEstimate e = filter.step(s, i < 500);
      if (!drawn || i < 2020) continue;
      outside += tilt_rad(error_of(motion, e)) > 3.5 * std::hypot(e.sigma_roll_rad, e.sigma_pitch_rad);
      ok += e.status == AttitudeStatus::kOk;
    }
    EXPECT_EQ(ok, 0) << "seed " << seed;
    EXPECT_LT(outside, 10) << "seed " << seed;
  }
}

/// At rest gravity shows the tilt: a filter that was sure of another one does not stay sure.
TEST(AttitudeHonesty, ATiltThatRestContradictsIsGivenUp) {
  RandomMotion motion({}, 4);
  AttitudeFilter filter;
  AttitudeEstimate e;
  for (int i = 0; i < 1000; ++i) e = filter.step(motion.next(true), true);
  const Quat shifted = exp_quat(Vec3(0.17, 0.0, 0.0));  // 10 degrees, 17 deviations of its offset
  for (int i = 0; i < 500; ++i) {
    CalibratedSample s = motion.next(true);
    s.acc_mps2 = array(Vec3(shifted * vec(s.acc_mps2)));
    e = filter.step(s, true);
  }
  const Vec3 up = quat(e.q_world_body) * (shifted * (motion.q_world_body().conjugate() * Vec3::UnitZ()));
  EXPECT_LT(std::acos(std::min(1.0, up.z())) * kDegPerRad, 5.0);
}

TEST(AttitudeHonesty, AMagnetThatHasJustComeLeavesTheHeading) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    RandomMotion motion({}, seed);
    AttitudeFilter filter;
    AttitudeEstimate e;
    double worst = 0.0;
    for (int i = 0; i < 9000; ++i) {
      CalibratedSample s = motion.next(false);
      if (i > 6000) s.mag_uT[2] += 60.0;
      e = filter.step(s, false);
      if (i > 6000) worst = std::max(worst, std::abs(error_of(motion, e).z()));
    }
    EXPECT_LT(worst * kDegPerRad, 12.0) << "seed " << seed;
  }
}

TEST(AttitudeHonesty, IronOfHalfAMilliteslaIsFoundByTurning) {
  MotionParams raw;
  raw.hard_iron_uT = {85.0, 210.0, -460.0};
  for (unsigned seed = 1; seed <= 4; ++seed) {
    RandomMotion motion(raw, seed);
    AttitudeFilter filter;
    AttitudeEstimate e;
    int outside = 0;
    for (int i = 0; i < 6000; ++i) {
      e = filter.step(motion.next(false), false);
      outside += std::abs(error_of(motion, e).z()) > 3.0 * e.sigma_yaw_rad;
    }
    EXPECT_EQ(e.heading, HeadingReference::kMagnetic);
    EXPECT_LT(std::abs(error_of(motion, e).z()) * kDegPerRad, 6.0);
    EXPECT_LT(outside, 120);
  }
}

/// Twice of what the prior expects, no more: half a minute of turning shows it.
TEST(AttitudeHonesty, IronOfTwoDeviationsIsFoundByTurning) {
  MotionParams magnetised;
  magnetised.hard_iron_uT = {15.0, -12.0, 9.0};
  Coverage coverage;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    RandomMotion motion(magnetised, seed);
    AttitudeFilter filter;
    double squares = 0.0;
    for (int i = 0; i < 6000; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(i < 500), i < 500);
      const double error = error_of(motion, e).z();
      coverage.note(std::abs(error) < 3.0 * e.sigma_yaw_rad);
      if (i >= 3000) squares += error * error;
    }
    EXPECT_LT(std::sqrt(squares / 3000.0) * kDegPerRad, 5.0) << "seed " << seed;
  }
  EXPECT_GT(coverage.share(), 0.98);
}

/// The same body in the same motion: how the sensor is mounted in it changes nothing but the rotation.
TEST(AttitudeHonesty, TheMountingOfTheSensorDoesNotMatter) {
  const Quat mounting = exp_quat(Vec3(0.9, -1.1, 0.6));
  RandomMotion motion({}, 7);
  AttitudeFilter plain, mounted;
  for (int i = 0; i < 3000; ++i) {
    CalibratedSample s = motion.next(i % 1500 < 500);
    const AttitudeEstimate a = plain.step(s, i % 1500 < 500);
    for (Array3* reading : {&s.acc_mps2, &s.gyr_radps, &s.mag_uT})
      *reading = array(Vec3(mounting.conjugate() * vec(*reading)));
    const AttitudeEstimate b = mounted.step(s, i % 1500 < 500);
    const Quat same = quat(a.q_world_body) * mounting;
    // The field's start turns the world about the vertical by what the first sample gave each: equal from there on.
    if (i <= 20) continue;
    ASSERT_LT(log_quat(same * quat(b.q_world_body).conjugate()).norm(), 1e-6) << i;
  }
}

/// Turns without a magnetometer by a gyroscope of which the data sheet says one percent.
MotionParams turning_by_a_data_sheet() {
  MotionParams m;
  m.turn_radps = 3.0;
  m.gyr_matrix_sd = 0.01;
  return m;
}

AttitudeFilterParams without_magnetometer() {
  AttitudeFilterParams p;
  p.use_magnetometer = false;
  return p;
}

/// The heading's error since it was begun: without a magnetometer it is counted from there.
class HeadingSince {
 public:
  void begin(const RandomMotion& motion, const AttitudeEstimate& e) { start_ = apart(motion, e); }
  [[nodiscard]] double error_rad(const RandomMotion& motion, const AttitudeEstimate& e) const {
    return log_quat(apart(motion, e) * start_.conjugate()).z();
  }

 private:
  static Quat apart(const RandomMotion& motion, const AttitudeEstimate& e) {
    return motion.q_world_body() * quat(e.q_world_body).conjugate();
  }
  Quat start_ = Quat::Identity();
};

TEST(AttitudeHonesty, AGyroscopeOfOnePercentTurnsTheHeadingByAsMuchAsIsStated) {
  Coverage coverage;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    RandomMotion motion(turning_by_a_data_sheet(), seed);
    AttitudeFilter filter(without_magnetometer());
    HeadingSince heading;
    for (int i = 0; i < 9000; ++i) {
      const AttitudeEstimate e = filter.step(motion.next(i < 500), i < 500);
      if (i == 499) heading.begin(motion, e);
      if (i > 500 && i % 100 == 0) coverage.note(std::abs(heading.error_rad(motion, e)) < 3.0 * e.sigma_yaw_rad);
    }
  }
  EXPECT_GT(coverage.share(), 0.97);
}

/// What the calibration found from gravity about the turns sets right what they have done to the heading, and those to
/// come; the corrected rates stay what they were only as far as it knows nothing better.
TEST(AttitudeHonesty, AMatrixThatTheCalibrationHasLearntIsTaken) {
  double left = 0.0, taken = 0.0;
  Coverage coverage;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    RandomMotion motion(turning_by_a_data_sheet(), seed);
    AttitudeFilter alone(without_magnetometer()), told(without_magnetometer());
    const CalibrationSnapshot before;
    CalibrationSnapshot learnt;
    learnt.gyr.matrix = array(Mat3(Mat3::Identity() - motion.gyr_matrix()));
    learnt.gyr.matrix_sd.fill(0.001);
    HeadingSince of_alone, of_told;
    for (int i = 0; i < 9000; ++i) {
      CalibratedSample s = motion.next(i < 500);
      const AttitudeEstimate a = alone.step(s, i < 500);
      if (i == 4500) told.rebase(before, learnt);
      if (i >= 4500) s.gyr_radps = array(Vec3(mat(learnt.gyr.matrix) * vec(s.gyr_radps)));
      const AttitudeEstimate t = told.step(s, i < 500);
      if (i == 499) of_alone.begin(motion, a), of_told.begin(motion, t);
      if (i <= 4500 || i % 100 != 0) continue;
      left += std::pow(of_alone.error_rad(motion, a), 2);
      taken += std::pow(of_told.error_rad(motion, t), 2);
      coverage.note(std::abs(of_told.error_rad(motion, t)) < 3.0 * t.sigma_yaw_rad);
    }
  }
  EXPECT_LT(taken, 0.2 * left);
  EXPECT_GT(coverage.share(), 0.97);
}

}  // namespace
}  // namespace stillpoint::fusion

/// What the result may not depend on: mounting (attitude_honesty_test.cpp), the heading of the world, the origin of
/// time, the rate at which the same motion is sampled.
#include <cmath>
#include <numbers>

#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::RandomMotion;

bool rests(int i) { return i % 1500 < 500; }

Quat about_vertical(double angle_rad) { return Quat(Eigen::AngleAxisd(angle_rad, Vec3::UnitZ())); }

TEST(AttitudeInvariance, AWorldThatIsTurnedTurnsTheResultAndNothingElse) {
  constexpr double kTurn_rad = 2.3;
  RandomMotion motion({}, 11);
  AttitudeFilterParams turned_params;
  turned_params.declination_rad = std::remainder(-kTurn_rad, 2.0 * std::numbers::pi);
  AttitudeFilter plain, turned(turned_params);
  AttitudeFilterParams level;
  level.use_magnetometer = false;
  AttitudeFilter plain_6d(level), turned_6d(level);
  turned_6d.reset(kTurn_rad);
  plain_6d.reset(0.0);
  for (int i = 0; i < 4000; ++i) {
    const CalibratedSample s = motion.next(rests(i));
    const AttitudeEstimate a = plain.step(s, rests(i)), b = turned.step(s, rests(i));
    const AttitudeEstimate c = plain_6d.step(s, rests(i)), d = turned_6d.step(s, rests(i));
    const auto apart = [](const AttitudeEstimate& x, const AttitudeEstimate& y) {
      return log_quat(about_vertical(kTurn_rad) * quat(x.q_world_body) * quat(y.q_world_body).conjugate()).norm();
    };
    if (i > 20) {  // the first field turns the world
      ASSERT_LT(apart(a, b), 1e-9) << i;
      ASSERT_NEAR(a.sigma_yaw_rad, b.sigma_yaw_rad, 1e-9 * a.sigma_yaw_rad) << i;
    }
    ASSERT_LT(apart(c, d), 1e-9) << i;
    ASSERT_NEAR(c.sigma_roll_rad, d.sigma_roll_rad, 1e-9) << i;
  }
}

TEST(AttitudeInvariance, TheOriginOfTimeDoesNotMatterToTheLastBit) {
  RandomMotion motion({}, 12);
  AttitudeFilter early, late;
  for (int i = 0; i < 2000; ++i) {
    CalibratedSample s = motion.next(rests(i));
    const AttitudeEstimate a = early.step(s, rests(i));
    s.t_ns += 1'700'000'000'123'456'789;
    const AttitudeEstimate b = late.step(s, rests(i));
    ASSERT_EQ(a.q_world_body, b.q_world_body) << i;
    ASSERT_EQ(a.covariance_world_rad2, b.covariance_world_rad2) << i;
  }
}

/// Each reading holds over its period; cut in four, the same motion has four times the rate.
TEST(AttitudeInvariance, TheRateOfSamplingDoesNotMatter) {
  test::MotionParams slow;
  slow.turn_radps = 0.5;
  RandomMotion motion(slow, 13);
  AttitudeFilterParams exact;
  exact.stamp_sd = 0.0;  // the doubt about a stamp is a part of the step
  AttitudeFilter coarse(exact), fine(exact);
  for (int i = 0; i < 4000; ++i) {
    CalibratedSample s = motion.next(rests(i));
    const AttitudeEstimate a = coarse.step(s, rests(i));
    AttitudeEstimate b;
    const std::int64_t end_ns = s.t_ns;
    for (int part = 3; part >= 0; --part) {
      s.t_ns = end_ns - part * 2'500'000;
      b = fine.step(s, rests(i));
    }
    if (i < 200) continue;
    ASSERT_LT(test::error_world(quat(a.q_world_body), quat(b.q_world_body)).norm(), 0.02) << i;
    // Not closer: the probability of a jump (A27) goes with the exponential of what was heard.
    ASSERT_NEAR(a.sigma_roll_rad / b.sigma_roll_rad, 1.0, 0.5) << i;
    ASSERT_NEAR(a.sigma_yaw_rad / b.sigma_yaw_rad, 1.0, 0.5) << i;
  }
}

}  // namespace
}  // namespace stillpoint::fusion

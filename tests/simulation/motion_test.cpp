#include "simulation/motion.h"

#include <gmock/gmock.h>

#include "core/so3.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {
namespace {

MotionConfig of_kind(const std::string& kind) {
  MotionConfig c;
  c.kind = kind;
  c.duration_s = kind == "worn_day" ? 86400.0 : 120.0;
  return c;
}

class EveryMotion : public ::testing::TestWithParam<std::string> {};

/// Velocity, acceleration, rate and angular acceleration against central differences of path and orientation. The error
/// of a difference over 2h is h^2/6 times the third derivative of the fastest part; h is a 2000th of that part's
/// period.
TEST_P(EveryMotion, DerivativesAreThoseOfThePath) {
  const MotionConfig c = of_kind(GetParam());
  const auto motion = make_motion(c, 7);
  const double fastest_hz = GetParam() == "drone" ? 2.0 * c.vibration_hz : GetParam() == "vehicle" ? 30.0 : 15.0;
  const double h = 5e-4 / fastest_hz;
  double worst_v = 0.0, worst_a = 0.0, worst_w = 0.0, worst_dw = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.37 + c.duration_s * 0.99 * i / 4000.0;
    const MotionState s = motion->at(t), before = motion->at(t - h), after = motion->at(t + h);
    const Vec3 v = (after.position_m - before.position_m) / (2 * h);
    const Vec3 a = (after.velocity_mps - before.velocity_mps) / (2 * h);
    const Vec3 w = log_quat(before.q_world_body.conjugate() * after.q_world_body) / (2 * h);
    const Vec3 dw = (after.rate_radps - before.rate_radps) / (2 * h);
    worst_v = std::max(worst_v, (v - s.velocity_mps).norm());
    worst_a = std::max(worst_a, (a - s.acceleration_mps2).norm() / (1.0 + s.acceleration_mps2.norm()));
    worst_w = std::max(worst_w, (w - s.rate_radps).norm());
    worst_dw =
        std::max(worst_dw, (dw - s.angular_acceleration_radps2).norm() / (1.0 + s.angular_acceleration_radps2.norm()));
    ASSERT_NEAR(s.q_world_body.norm(), 1.0, 1e-12);
    ASSERT_TRUE(s.moving || s.rate_radps.norm() == 0.0) << "turns at rest, at " << t;
  }
  EXPECT_LT(worst_v, 1e-5);
  EXPECT_LT(worst_a, 1e-4);
  EXPECT_LT(worst_w, 1e-4);
  EXPECT_LT(worst_dw, 1e-3);
}

TEST_P(EveryMotion, IsAFunctionOfTimeAndSeedAlone) {
  const MotionConfig c = of_kind(GetParam());
  const auto one = make_motion(c, 3), same = make_motion(c, 3);
  for (const double t : {100.0, 3.0, 55.5}) {
    EXPECT_EQ(one->at(t).position_m, same->at(t).position_m);
    EXPECT_EQ(one->at(t).q_world_body.coeffs(), same->at(t).q_world_body.coeffs());
  }
}

/// Fourth-order Runge-Kutta on dq/dt = q w / 2 over 10 s of motion comes back to the true attitude and, with the double
/// integral of the acceleration, to the true position.
TEST_P(EveryMotion, IntegratesBackToAttitudeAndPosition) {
  const MotionConfig c = of_kind(GetParam());
  const auto motion = make_motion(c, 11);
  const double h = GetParam() == "drone" ? 1e-4 : 1e-3, start_s = GetParam() == "worn_day" ? 40000.0 : 20.0;
  const MotionState first = motion->at(start_s);
  Quat q = first.q_world_body;
  Vec3 p = first.position_m, v = first.velocity_mps;
  const auto steps = static_cast<int>(std::lround(10.0 / h));
  const auto slope = [](const Quat& at, const Vec3& w) {
    return Eigen::Vector4d(0.5 * (at * Quat(0.0, w.x(), w.y(), w.z())).coeffs());
  };
  for (int i = 0; i < steps; ++i) {
    const double t = start_s + i * h;
    const MotionState a = motion->at(t), b = motion->at(t + 0.5 * h), d = motion->at(t + h);
    const Eigen::Vector4d q0 = q.coeffs();
    const Eigen::Vector4d k1 = slope(q, a.rate_radps),
                          k2 = slope(Quat(Eigen::Vector4d(q0 + 0.5 * h * k1)), b.rate_radps);
    const Eigen::Vector4d k3 = slope(Quat(Eigen::Vector4d(q0 + 0.5 * h * k2)), b.rate_radps);
    const Eigen::Vector4d k4 = slope(Quat(Eigen::Vector4d(q0 + h * k3)), d.rate_radps);
    q = Quat(Eigen::Vector4d(q0 + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))).normalized();
    // Simpson's rule for the velocity and its counterpart of the same order for the position.
    p += h * v + h * h / 6.0 * (a.acceleration_mps2 + 2.0 * b.acceleration_mps2);
    v += h / 6.0 * (a.acceleration_mps2 + 4.0 * b.acceleration_mps2 + d.acceleration_mps2);
  }
  const MotionState last = motion->at(start_s + steps * h);
  EXPECT_LT(log_quat(q.conjugate() * last.q_world_body).norm(), 1e-6);
  EXPECT_LT((p - last.position_m).norm(), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryMotion, ::testing::ValuesIn(motion_kind_names()),
                         [](const auto& kind) { return kind.param; });

TEST(RestPoses, CoverTheSphereEvenly) {
  MotionConfig c = of_kind("rest_poses");
  c.duration_s = 1000.0;
  const auto motion = make_motion(c, 1);
  Mat3 spread = Mat3::Zero();
  int rests = 0;
  for (double t = 0.0; t < 24 * 5.0; t += 0.1) {
    const MotionState s = motion->at(t);
    if (s.moving) continue;
    const Vec3 up = s.q_world_body.conjugate() * Vec3::UnitZ();
    spread += up * up.transpose();
    ++rests;
  }
  // Rest lengths differ, so the moment matrix is near a third of the identity but not on it.
  EXPECT_LT((spread / rests - Mat3::Identity() / 3.0).norm(), 0.1);
}

TEST(WornDay, RestsPreferFewDirections) {
  const auto motion = make_motion(of_kind("worn_day"), 5);
  Vec3 mean = Vec3::Zero();
  int rests = 0;
  for (double t = 8 * 3600.0; t < 22 * 3600.0; t += 7.0) {
    const MotionState s = motion->at(t);
    if (s.moving) continue;
    mean += s.q_world_body.conjugate() * Vec3::UnitZ();
    ++rests;
  }
  EXPECT_GT((mean / rests).norm(), 0.4);  // evenly spread rests would give about 0.03
}

TEST(Vehicle, AcceleratesForSeconds) {
  const auto motion = make_motion(of_kind("vehicle"), 1);
  int sustained = 0, longest = 0;
  for (double t = 0.0; t < 100.0; t += 0.1) {
    const Vec3 a = motion->at(t).acceleration_mps2;
    sustained = a.head<2>().norm() > 1.0 ? sustained + 1 : 0;
    longest = std::max(longest, sustained);
  }
  EXPECT_GT(longest, 20);
}

TEST(Walking, HeelStrikesExceedTheSwing) {
  const auto motion = make_motion(of_kind("walking"), 1);
  double highest = 0.0;
  for (double t = 20.0; t < 40.0; t += 0.002)
    highest = std::max(highest, std::abs(motion->at(t).acceleration_mps2.z()));
  EXPECT_GT(highest, 5.0);
  EXPECT_LT(highest, 40.0);
}

}  // namespace
}  // namespace stillpoint::sim

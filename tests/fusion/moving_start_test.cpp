/// Attitudes that begin in the middle of a motion.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::RandomMotion;

/// Share of the time within three deviations, and the tilt [rad] from row `from` on.
struct Course {
  double inside = 0.0, tilt_rms = 0.0;
};

bool inside(const Vec3& error, const AttitudeEstimate& e) {
  const Eigen::Matrix2d plane = mat(e.covariance_world_rad2).topLeftCorner<2, 2>();
  return error.head<2>().dot(plane.inverse() * error.head<2>()) <= 11.83;
}

template <class Next>  // sample and true attitude
Course course(int rows, int from, Next&& next) {
  AttitudeFilter filter;
  Course c;
  for (int i = 0; i < rows; ++i) {
    const auto [s, truth] = next(i);
    const AttitudeEstimate e = filter.step(s, false);
    const Vec3 error = test::error_world(truth, quat(e.q_world_body));
    c.inside += inside(error, e) ? 1.0 / rows : 0.0;
    if (i >= from) c.tilt_rms += tilt_rad(error) * tilt_rad(error) / (rows - from);
  }
  c.tilt_rms = std::sqrt(c.tilt_rms);
  return c;
}

/// Mean tilt rms [rad] of 20 seeds that are shaken from the start on, `lost` rows missing after 1.5 s; each of them
/// inside more than `least`.
double shaken(int rows, int lost, double least) {
  test::MotionParams params;
  params.speed_mps = 2.0, params.speed_time_s = 0.1, params.turn_radps = 3.0;
  double tilt_rms = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomMotion motion(params, seed);
    const Course c = course(rows, 300, [&](int i) {
      for (int k = 0; i == 150 && k < lost; ++k) (void)motion.next(false);
      return std::pair{motion.next(false), motion.q_world_body()};
    });
    EXPECT_GT(c.inside, least) << seed;
    tilt_rms += c.tilt_rms / 20;
  }
  return tilt_rms;
}

TEST(MovingStart, AShakenBodyDoesNotSayThatItsFirstReadingIsUp) {
  EXPECT_LT(shaken(1000, 0, 0.98), 0.06);  // without (A32) 0.12, inside 96 %
}

/// Rows are missing in the middle of it: nobody saw how the body turned, so what was up before is no longer known.
TEST(MovingStart, APauseLosesWhatWasKnownOfTheVertical) {
  // Where the start goes on as if nothing had been lost 0.23, one seed inside 81 %.
  EXPECT_LT(shaken(800, 200, 0.96), 0.14);
}

/// Eights of two rounds of 3 m at 2.5 m/s, a stride of 1.35 Hz that swings the body by
/// 0.3 rad and lifts it with 10 m/s^2.
TEST(MovingStart, ARunnersRoundsAreNoOffset) {
  Course mean;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const double stride = 2.0 * std::numbers::pi * 1.35, round = 2.5 / 3.0, phase = normal(random), dt = 0.01;
    const Quat mount = exp_quat(Vec3(normal(random), normal(random), normal(random)));
    const Vec3 offset = 0.01 * Vec3(normal(random), normal(random), normal(random));
    const double lap_s = 2.0 * std::numbers::pi / round;
    const auto left = [&](double t) { return std::fmod(t + 100.0 * lap_s, 2.0 * lap_s) < lap_s; };
    const auto heading = [&](double t) { return left(t) ? round * t : -round * t; };  // both full turns
    const auto attitude = [&](double t) {
      return Quat(Eigen::AngleAxisd(heading(t), Vec3::UnitZ())) *
             Quat(Eigen::AngleAxisd(0.3 * std::sin(stride * t + phase), Vec3::UnitY())) * mount;
    };
    const Course c = course(6000, 1000, [&](int i) {
      const double t = i * dt;
      const Quat q = attitude(t), before = attitude(t - dt);
      // Ahead is x: the force that keeps it on its round points to its left, or right.
      const double inward = left(t) ? 2.5 * round : -2.5 * round;
      const Vec3 world(-inward * std::sin(heading(t)), inward * std::cos(heading(t)),
                       kStandardGravity_mps2 + 10.0 * std::sin(2.0 * stride * t));
      CalibratedSample s;
      s.has = kAcc | kGyr;
      s.t_ns = static_cast<std::int64_t>(i + 1) * 10'000'000;
      s.gyr_radps = array(Vec3(log_quat(before.conjugate() * q) / dt + offset +
                               2e-3 * Vec3(normal(random), normal(random), normal(random))));
      s.acc_mps2 = array(Vec3(q.conjugate() * world + 0.3 * Vec3(normal(random), normal(random), normal(random))));
      return std::pair{s, q};
    });
    mean.inside += c.inside / 10, mean.tilt_rms += c.tilt_rms / 10;
  }
  EXPECT_GT(mean.inside, 0.9);  // without what a bounce says of the speed 0.47, and 0.12
  EXPECT_LT(mean.tilt_rms, 0.09);
}

}  // namespace
}  // namespace stillpoint::fusion

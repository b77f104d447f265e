/// What a pause leaves unknown lies along the axes about which the body turns, wherever these lie in the body.
#include "fusion/rate_bridge.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace stillpoint::fusion {
namespace {

constexpr double kPeriod_s = 0.05;

/// A rate that wanders about one axis, with its deviation [rad/s] and correlation time [s].
class Wandering {
 public:
  Wandering(const Vec3& axis, double sd_radps, double time_s, unsigned seed)
      : axis_(axis), sd_(sd_radps), time_(time_s), random_(seed) {}
  Vec3 step(double dt_s) {
    const double keep = std::exp(-dt_s / time_);
    rate_ = keep * rate_ + sd_ * std::sqrt(1.0 - keep * keep) * normal_(random_);
    return rate_ * axis_;
  }

 private:
  Vec3 axis_;
  double sd_, time_, rate_ = 0.0;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

RateBridge learnt(Wandering& motion) {
  RateBridge bridge;
  for (int k = 0; k < 400; ++k) bridge.observe(motion.step(kPeriod_s), kPeriod_s);
  return bridge;
}

TEST(RateBridge, OfATurnAboutOneAxisIsUnknownAlongThatAxisOnly) {
  const Vec3 axis = Vec3(1.0, 1.0, 0.0).normalized(), across = Vec3(1.0, -1.0, 0.0).normalized();
  Wandering motion(axis, 4.0, 0.3, 1);
  const Mat3 C = learnt(motion).bridge_rad2(0.5);
  const double along = axis.dot(C * axis), aside = across.dot(C * across);
  EXPECT_GT(along, 50.0 * aside);
  EXPECT_NEAR(aside, Vec3::UnitZ().dot(C * Vec3::UnitZ()), 1e-9 * along) << "what is left is the same about any axis";
  EXPECT_GT(aside, 0.0);
}

TEST(RateBridge, TurnsWithTheBodysAxes) {
  const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  RateBridge here, turned;
  Wandering x(Vec3::UnitX(), 3.0, 0.3, 1), y(Vec3::UnitY(), 1.0, 0.3, 2);
  for (int k = 0; k < 400; ++k) {
    const Vec3 rate = x.step(kPeriod_s) + y.step(kPeriod_s);
    here.observe(rate, kPeriod_s);
    turned.observe(R * rate, kPeriod_s);
  }
  const Mat3 C = here.bridge_rad2(0.4);
  EXPECT_TRUE(turned.bridge_rad2(0.4).isApprox(R * C * R.transpose(), 1e-9));
}

TEST(RateBridge, StatesTheErrorOfTheStraightLineBetweenBothEnds) {
  constexpr int kTrials = 300, kSteps = 100;
  for (const double gap_s : {0.1, 0.3, 1.0}) {
    double nees = 0.0;
    int outside = 0;
    for (unsigned trial = 0; trial < kTrials; ++trial) {
      Wandering motion(Vec3::UnitX(), 5.0, 0.3, trial);
      const RateBridge bridge = learnt(motion);
      const double dt_s = gap_s / kSteps;
      const double first = motion.step(dt_s).x();
      double sum = 0.5 * first, last = first;
      for (int k = 1; k <= kSteps; ++k) {
        last = motion.step(dt_s).x();
        sum += k < kSteps ? last : 0.5 * last;
      }
      const double error = dt_s * sum - 0.5 * gap_s * (first + last);
      const double variance = bridge.bridge_rad2(gap_s)(0, 0);
      nees += error * error / variance / kTrials;
      outside += error * error > 9.0 * variance;
    }
    EXPECT_GT(nees, 0.1) << gap_s;
    EXPECT_LT(nees, 1.2) << gap_s;
    EXPECT_LE(outside, kTrials / 100) << gap_s;
  }
}

}  // namespace
}  // namespace stillpoint::fusion

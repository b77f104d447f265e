/// The two finders of the sensor's own magnetism by themselves: what they find, and what a new calibration makes of it.
#include "fusion/hard_iron.h"

#include <gtest/gtest.h>

#include <random>

#include "core/so3.h"
#include "fusion/iron_finder.h"

namespace stillpoint::fusion {
namespace {

const Vec3 kPlace_uT(0.0, 18.0, -42.0), kBody_uT(6.0, -4.0, 3.0);

/// Attitudes one after the other, a fifth of a radian apart about any axis; readings u = R^T m + h, then K u + c.
struct Turning {
  std::mt19937_64 random{11};
  std::normal_distribution<double> normal;
  Quat q = Quat::Identity();
  double K = 1.0;
  Vec3 c = Vec3::Zero(), body_uT = kBody_uT;

  Mat3 next(double angle_rad) {
    const Vec3 axis(normal(random), normal(random), normal(random));
    q = (q * exp_quat(angle_rad * axis.normalized())).normalized();
    return q.toRotationMatrix();
  }
  [[nodiscard]] Vec3 seen_world_uT(const Mat3& R) const { return R * (K * (R.transpose() * kPlace_uT + body_uT) + c); }
};

HardIronParams without_doubt() {
  HardIronParams params;
  params.doubt = 0.0;
  return params;
}

void feed(HardIron& iron, Turning& sensor, int means) {
  for (int k = 0; k < means; ++k) {
    const Mat3 R = sensor.next(1.0);
    iron.observe(without_doubt(), sensor.seen_world_uT(R), R, 1.0);
  }
}

void feed(IronFinder& finder, Turning& sensor, int turns) {
  for (int k = 0; k < turns; ++k) {
    const Mat3 R = sensor.next(0.2);
    finder.observe(sensor.seen_world_uT(R), R, 0.1);
  }
}

TEST(HardIron, FindsWhatTurnsWithTheBody) {
  const HardIronParams params = without_doubt();
  HardIron iron;
  iron.reset(params);
  EXPECT_FALSE(iron.settled());
  Turning sensor;
  feed(iron, sensor, 200);
  EXPECT_LT((iron.body_uT(params) - kBody_uT).norm(), 0.2);
  EXPECT_TRUE(iron.settled());
  EXPECT_LT(iron.left_uT2(params).trace(), 3.0);
}

TEST(HardIron, AfterANewCalibrationStatesTheSameFieldInItsReadings) {
  const HardIronParams params = without_doubt();
  HardIron iron;
  iron.reset(params);
  Turning sensor;
  feed(iron, sensor, 200);
  const Vec3 before = iron.body_uT(params), c(5.0, -7.0, 2.0);
  const Mat3 left = iron.left_uT2(params);
  Mat3 K;
  K << 1.1, 0.05, -0.02, 0.0, 0.9, 0.04, 0.03, 0.0, 1.2;
  HardIron changed = iron;
  changed.rebase(K, c, std::nullopt);
  EXPECT_LT((changed.body_uT(params) - (K * before + c)).norm(), 1e-9);
  EXPECT_LT((changed.left_uT2(params) - K * left * K.transpose()).norm(), 1e-9);
}

TEST(HardIron, GoesOnWithTheNewReadingsAsIfItHadNeverSeenOthers) {
  const HardIronParams params = without_doubt();
  for (const double K : {0.6, 1.4}) {
    HardIron iron;
    iron.reset(params);
    Turning sensor;
    feed(iron, sensor, 200);
    sensor.K = K;
    sensor.c = Vec3(5.0, -7.0, 2.0);
    iron.rebase(K * Mat3::Identity(), sensor.c, std::nullopt);
    feed(iron, sensor, 12);  // had the place not followed, all would be a misfit, and eleven of them begin anew
    EXPECT_LT((iron.body_uT(params) - (K * kBody_uT + sensor.c)).norm(), 0.2) << K;
  }
}

TEST(HardIron, ANewCalibrationThatOnlyScalesIsAChangeOfUnit) {
  // GIVEN noisy readings in one unit, and in another of half its size from the fiftieth on
  constexpr double kUnit = 2.0;
  HardIronParams params = without_doubt(), scaled = params;
  for (double HardIronParams::*x : {&HardIronParams::sd_uT, &HardIronParams::walk_uT_rtHz,
                                    &HardIronParams::field_walk_uT_rtHz, &HardIronParams::noise_uT})
    scaled.*x *= kUnit;
  HardIron in_one, in_two;
  in_one.reset(params);
  in_two.reset(params);
  Turning sensor;
  for (int k = 0; k < 60; ++k) {
    const Mat3 R = sensor.next(0.3);
    const Vec3 noise(sensor.normal(sensor.random), sensor.normal(sensor.random), sensor.normal(sensor.random));
    const Vec3 seen = sensor.seen_world_uT(R) + 2.0 * noise;
    if (k == 50) in_two.rebase(kUnit * Mat3::Identity(), Vec3::Zero(), std::nullopt);
    in_one.observe(params, seen, R, 1.0);
    in_two.observe(k < 50 ? params : scaled, k < 50 ? seen : Vec3(kUnit * seen), R, 1.0);
  }
  // THEN both have found the same, to the rounding
  EXPECT_LT((in_two.body_uT(scaled) - kUnit * in_one.body_uT(params)).norm(), 1e-9);
  EXPECT_LT((in_two.left_uT2(scaled) - kUnit * kUnit * in_one.left_uT2(params)).norm(), 1e-9);
}

TEST(HardIron, WhoeverKnowsTheOffsetBetterStatesItFromThereOn) {
  const HardIronParams params = without_doubt();
  HardIron iron;
  iron.reset(params);
  Turning sensor;
  feed(iron, sensor, 200);
  const Mat3 poor = 25.0 * Mat3::Identity(), good = 0.01 * Mat3::Identity();
  HardIron kept = iron, given = iron;
  kept.rebase(Mat3::Identity(), -kBody_uT, poor);
  EXPECT_LT((kept.left_uT2(params) - iron.left_uT2(params)).norm(), 1e-9);
  given.rebase(Mat3::Identity(), -kBody_uT, good);
  EXPECT_EQ(given.body_uT(params), Vec3(Vec3::Zero()));
  EXPECT_LT((given.left_uT2(params) - good).norm(), 1e-12);
  sensor.c = -kBody_uT;
  feed(given, sensor, 8);
  // Nothing of the evidence before works on: the offset stays where it is, and only its walk is added.
  EXPECT_LT(given.body_uT(params).norm(), 0.1);
  EXPECT_NEAR(given.left_uT2(params).trace(), 3.0 * (0.01 + 8.0 * params.walk_uT_rtHz * params.walk_uT_rtHz), 0.001);
}

TEST(HardIron, BeginsAnewAfterTenSecondsThatItCannotExplain) {
  const HardIronParams params = without_doubt();
  HardIron iron;
  iron.reset(params);
  Turning sensor;
  feed(iron, sensor, 200);
  const Vec3 before = iron.body_uT(params);
  sensor.body_uT = Vec3(60.0, -40.0, 30.0);
  feed(iron, sensor, 10);
  EXPECT_EQ(iron.body_uT(params), before) << "a magnet may only pass";
  feed(iron, sensor, 1);
  EXPECT_EQ(iron.body_uT(params), Vec3(Vec3::Zero()));
}

TEST(IronFinder, FindsIronOfAnySizeFromTurns) {
  for (const double size : {1.0, 100.0}) {
    IronFinder finder;
    Turning sensor;
    sensor.body_uT = size * kBody_uT;
    feed(finder, sensor, 10);
    EXPECT_FALSE(finder.known());
    feed(finder, sensor, 50);
    EXPECT_TRUE(finder.known());
    EXPECT_LT((finder.body_uT() - sensor.body_uT).norm(), 1e-3 * sensor.body_uT.norm());
  }
}

TEST(IronFinder, AfterANewCalibrationStatesTheSameIronInItsReadingsAndGoesOn) {
  for (const double K : {0.7, 1.4}) {
    IronFinder finder;
    Turning sensor;
    feed(finder, sensor, 60);
    const Mat3 floor = 1.5 * 1.5 * Mat3::Identity();  // of an uneven place, whatever the readings
    const Mat3 before = finder.covariance_uT2() - floor;
    sensor.K = K;
    sensor.c = Vec3(50.0, -70.0, 20.0);
    const Vec3 after = K * kBody_uT + sensor.c;
    finder.rebase(K * Mat3::Identity(), sensor.c);
    EXPECT_LT((finder.body_uT() - after).norm(), 0.01) << K;
    // The residual's own floor is counted over one turn fewer: 5 %.
    EXPECT_LT((finder.covariance_uT2() - floor - K * K * before).norm(), 0.05 * K * K * before.norm()) << K;
    feed(finder, sensor, 40);
    EXPECT_LT((finder.body_uT() - after).norm(), 0.05) << K;
  }
}

TEST(IronFinder, ACalibrationThatTakesALargeIronOutLeavesNoDoubtBehind) {
  IronFinder finder;
  Turning sensor;
  sensor.body_uT = 20.0 * kBody_uT;
  feed(finder, sensor, 60);
  const Mat3 before = finder.covariance_uT2();
  finder.rebase(Mat3::Identity(), -sensor.body_uT);
  EXPECT_LT(finder.body_uT().norm(), 0.01);
  EXPECT_LT((finder.covariance_uT2() - before).norm(), 0.05 * before.norm());
}

TEST(IronFinder, DrawsNoDifferenceBetweenReadingsOfTwoCalibrations) {
  IronFinder finder;
  Turning sensor;
  feed(finder, sensor, 8);  // so few that one false difference would show
  sensor.c = Vec3(50.0, -70.0, 20.0);
  finder.rebase(Mat3::Identity(), sensor.c);
  feed(finder, sensor, 4);
  EXPECT_LT((finder.body_uT() - kBody_uT - sensor.c).norm(), 0.1);
}

TEST(IronFinder, ACorrectionOfTheAttitudeIsNoTurn) {
  IronFinder finder;
  Turning sensor;
  const Mat3 corrected = exp_quat(Vec3(0.0, 0.3, 0.5)).toRotationMatrix();
  for (int k = 0; k < 60; ++k) {  // from the thirtieth on the estimated world is another one
    const Mat3 R = sensor.next(0.2);
    if (k == 30) finder.turn_world(corrected);
    const Mat3 seen_as = k < 30 ? R : Mat3(corrected * R);
    finder.observe((k < 30 ? Mat3(Mat3::Identity()) : corrected) * sensor.seen_world_uT(R), seen_as, 0.1);
  }
  EXPECT_LT((finder.body_uT() - kBody_uT).norm(), 1e-3);
}

}  // namespace
}  // namespace stillpoint::fusion

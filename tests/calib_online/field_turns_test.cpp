#include "calib_online/field_turns.h"

#include <gtest/gtest.h>

#include "calib_online/online_calibrator.h"
#include "core/units.h"
#include "tests/calib_online/synthetic.h"

namespace stillpoint::calib {
namespace {

/// Never at rest: rates about all axes that come and go.
test::Motion restless() {
  test::Motion m;
  m.rate_radps = [](double t) {
    return Vec3(1.2 * std::sin(0.9 * t), 1.0 * std::sin(1.3 * t + 1.0), 0.9 * std::sin(0.7 * t + 2.0));
  };
  return m;
}

test::SensorTruth iron() {
  test::SensorTruth t;
  t.H_mag << 1.04, 0.02, -0.01, 0.025, 0.97, 0.03, -0.015, 0.02, 0.99;  // trace three: the strength cannot be seen
  t.b_mag = Vec3(14.0, -20.0, 9.0);
  t.H_gyr << 1.002, 0.001, 0.0, -0.001, 0.999, 0.001, 0.0, 0.001, 1.001;
  return t;
}

/// The stages' way: turns alone, the rest detector is not asked.
struct Field {
  test::Synthetic source;
  FieldTurnFinder finder;
  OnlineCalibrator calibrator{{}, CalibrationSnapshot{}};
  int turns = 0;
  explicit Field(const test::SensorTruth& truth, unsigned seed) : source(truth, seed) {}
  void run(
      double duration_s, const test::Motion& motion,
      const std::function<Vec3(double)>& world_uT = [](double) { return Vec3(Vec3::Zero()); }) {
    source.run(duration_s, motion, [&](RawSample s) {
      // What the world adds is seen through the same body and the same sensor.
      const Vec3 added = source.attitude().conjugate() * world_uT(in_seconds(s.t_ns));
      vec(s.mag_uT) += source.truth().H_mag.inverse() * added;
      if (auto turn = finder.push(s, 0, calibrator.snapshot(), {})) {
        ++turns;
        calibrator.absorb(*turn);
      }
    });
  }
  [[nodiscard]] const TriadCalibration& mag() const { return calibrator.snapshot().mag; }
};

/// rms over the sphere of the error of a calibrated field of 47 uT, the common scale aside, uT.
double field_error_uT(const test::SensorTruth& truth, const TriadCalibration& learnt) {
  double sum = 0.0;
  int n = 0;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (; n < 200; ++n) {
    const Vec3 u = 47.4 * Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 y = truth.H_mag.inverse() * u + truth.b_mag;
    sum += (learnt.apply(array(y), 25.0) - u).squaredNorm();
  }
  return std::sqrt(sum / n);
}

TEST(FieldTurns, HardAndSoftIronAreLearntInMotionWithoutRest) {
  Field field(iron(), 1);
  field.run(240.0, restless());
  ASSERT_EQ(field.mag().status, CalibrationStatus::kOk) << field.turns << " turns";
  const double before = field_error_uT(iron(), TriadCalibration{}), after = field_error_uT(iron(), field.mag());
  EXPECT_GT(before, 20.0);
  EXPECT_LT(after, 0.5);
}

TEST(FieldTurns, TheIronOfABoardIsLearntAndIsNoOtherSensor) {
  test::SensorTruth board = iron();
  board.b_mag = Vec3(600.0, -620.0, 480.0);
  Field field(board, 8);
  field.run(40.0, restless());
  EXPECT_NE(field.mag().status, CalibrationStatus::kReplaced);
  field.run(320.0, restless());
  ASSERT_EQ(field.mag().status, CalibrationStatus::kOk) << field.turns << " turns";
  EXPECT_LT(field_error_uT(board, field.mag()), 1.0);
}

TEST(FieldTurns, AGoodCalibrationStaysAndSaysSo) {
  Field field(test::SensorTruth{}, 2);
  field.run(240.0, restless());
  EXPECT_EQ(field.mag().status, CalibrationStatus::kFactory);
  EXPECT_EQ(field.mag().matrix, TriadCalibration{}.matrix);
  EXPECT_EQ(field.mag().bias, TriadCalibration{}.bias);
}

/// The same wrong turn in every pair: it moves the field across, never along, and its many pairs do not average it out.
TEST(FieldTurns, WhatAnUntrueGyroscopeDoesIsInTheStatedDeviation) {
  int inside = 0, all = 0;
  for (unsigned seed = 1; seed <= 14; ++seed) {
    test::SensorTruth truth = iron();
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, 0.012);
    for (double& element : truth.H_gyr.reshaped()) element += normal(random);
    Field field(truth, seed);
    field.run(300.0, restless());
    ASSERT_EQ(field.mag().status, CalibrationStatus::kOk) << seed;
    for (int axis = 0; axis < 3; ++axis, ++all)
      inside += std::abs(vec(field.mag().bias)[axis] - truth.b_mag[axis]) <
                3.0 * std::sqrt(mat(field.mag().bias_covariance)(axis, axis));
  }
  EXPECT_GE(inside, all - 1);
}

TEST(FieldTurns, TurnsAboutOneAxisAreNotObservable) {
  Field field(iron(), 3);
  test::Motion about_x;
  about_x.rate_radps = [](double t) { return Vec3(1.5 * std::sin(0.6 * t), 0.0, 0.0); };
  field.run(240.0, about_x);
  EXPECT_GT(field.turns, 100);
  EXPECT_EQ(field.mag().status, CalibrationStatus::kNotObservable);
  EXPECT_EQ(field.mag().bias, TriadCalibration{}.bias);
}

TEST(FieldTurns, AMagnetOnTheBodyIsSeenAndLearntAnew) {
  Field field(iron(), 4);
  field.run(200.0, restless());
  ASSERT_EQ(field.mag().status, CalibrationStatus::kOk);
  field.source.truth().b_mag += Vec3(-15.0, 10.0, 25.0);
  field.run(12.0, restless());
  EXPECT_EQ(field.mag().status, CalibrationStatus::kReplaced);
  field.run(200.0, restless());
  EXPECT_EQ(field.mag().status, CalibrationStatus::kOk);
  EXPECT_LT(field_error_uT(field.source.truth(), field.mag()), 1.2);
}

TEST(FieldTurns, AMagnetInTheWorldIsSetAside) {
  Field field(iron(), 5);
  field.run(200.0, restless());
  ASSERT_EQ(field.mag().status, CalibrationStatus::kOk);
  const double before = field_error_uT(iron(), field.mag());
  // Another room, a passing magnet, and back: the field of the world changes, not that of the body.
  field.run(60.0, restless(), [](double t) { return t > 205.0 ? Vec3(8.0, -12.0, 10.0) : Vec3(Vec3::Zero()); });
  field.run(60.0, restless(),
            [](double t) { return Vec3(25.0 * std::exp(-0.5 * std::pow((t - 290.0) / 2.0, 2)), 0, 0); });
  field.run(60.0, restless());
  EXPECT_EQ(field.mag().status, CalibrationStatus::kOk);
  EXPECT_LT(field_error_uT(iron(), field.mag()), before + 0.3);
}

TEST(FieldTurns, GapsClippingAndHeldReadingsGiveNoTurn) {
  test::Synthetic source(iron(), 6);
  FieldTurnFinder finder;
  std::vector<RawSample> samples;
  source.run(20.0, restless(), [&](const RawSample& s) { samples.push_back(s); });
  int clipped = 0, gaps = 0, held = 0, sound = 0;
  for (const RawSample& s : samples) sound += finder.push(s, 0, {}, {}).has_value();
  finder = {};
  for (const RawSample& s : samples) clipped += finder.push(s, kMag, {}, {}).has_value();
  finder = {};
  for (std::size_t k = 0; k < samples.size(); k += 40) gaps += finder.push(samples[k], 0, {}, {}).has_value();
  finder = {};
  for (RawSample s : samples) {
    s.mag_uT = samples[0].mag_uT;
    held += finder.push(s, 0, {}, {}).has_value();
  }
  EXPECT_GT(sound, 15);
  EXPECT_EQ(clipped + gaps + held, 0);
}

}  // namespace
}  // namespace stillpoint::calib

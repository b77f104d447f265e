/// What a rest window is worth to the accelerometer.
#include "calib_online/acc_learner.h"

#include <gtest/gtest.h>

#include <random>

namespace stillpoint::calib {
namespace {

constexpr double kNoise_mps2 = 0.05;  // of a window's mean; the model's floor is small beside it

/// What so many windows in a row, `apart` from each other, have told of the length of gravity along the first one.
double information(int windows, double apart_rad) {
  const AccLearnerParams params;
  AccLearner learner(params, TriadCalibration{});
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto up = [apart_rad](int k) {
    return Vec3(Eigen::AngleAxisd(k % 2 == 0 ? 0.0 : apart_rad, Vec3::UnitX()) * Vec3(0.3, 0.5, 0.81).normalized());
  };
  for (int k = 0; k < windows; ++k) {
    Window w;
    w.t_end_ns = (k + 1) * 60'000'000'000;
    w.has = kAcc | kTemp;
    w.temp_degC = 25.0;
    w.acc_mps2 =
        array(Vec3(params.gravity_mps2 * up(k) + kNoise_mps2 * Vec3(normal(random), normal(random), normal(random))));
    w.acc_cov = array(Mat3(kNoise_mps2 * kNoise_mps2 * Mat3::Identity()));
    learner.absorb(w);
  }
  AccFilter filter(params.filter, params.gravity_mps2);
  const double before = filter.innovation(up(0), 0.0).variance;
  filter.restore(learner.state().published);
  return 1.0 / filter.innovation(up(0), 0.0).variance - 1.0 / before;
}

TEST(AccLearner, TheSameDirectionAgainAndAgainStopsGrowingInWeightAtTen) {
  // Up to ten each counts; from there on the k-th counts 10 / k: 10 (1 + ln 10) for a hundred.
  EXPECT_NEAR(information(10, 0.0) / information(5, 0.0), 2.0, 0.4);
  EXPECT_NEAR(information(100, 0.0) / information(10, 0.0), 1.0 + std::log(10.0), 0.8);
}

TEST(AccLearner, TwentyDegreesApartIsAnotherDirectionAndFiveDegreesIsTheSame) {
  const double same = information(100, 0.0);
  EXPECT_LT(information(100, 5.0 * kRadPerDeg), 1.1 * same);
  EXPECT_GT(information(100, 20.0 * kRadPerDeg), 1.5 * same);
}

}  // namespace
}  // namespace stillpoint::calib

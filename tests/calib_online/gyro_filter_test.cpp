#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "calib_online/online_calibrator.h"

namespace stillpoint::calib {
namespace {

/// Windows of rest along one sweep of the temperature, a minute apart; the gyro's bias as given.
CalibrationSnapshot after_sweep(double from_degC, double to_degC, const std::function<Vec3(double)>& bias_radps) {
  OnlineCalibrator calibrator({}, CalibrationSnapshot{});
  std::mt19937_64 random(17);
  std::normal_distribution<double> normal;
  const double sd = 0.005 * kRadPerDeg;
  for (int k = 0; k < 240; ++k) {
    Window w;
    w.has = kAcc | kGyr | kTemp;
    w.t_end_ns = (k + 1) * 60'000'000'000;
    w.temp_degC = from_degC + (to_degC - from_degC) * k / 239.0;
    w.acc_mps2 = {0.0, 0.0, kStandardGravity_mps2};
    w.gyr_radps = array(Vec3(bias_radps(w.temp_degC) + sd * Vec3(normal(random), normal(random), normal(random))));
    w.acc_cov = w.gyr_cov = w.turn_cov = array(Mat3(sd * sd * Mat3::Identity()));
    calibrator.absorb(w);
  }
  return calibrator.snapshot();
}

/// On one sweep a slope of 0.03 deg/s/K is the temperature's; one of 0.003, as large as hysteresis may be, is not told
/// from it and is not carried to temperatures that come later. Either way the present bias is right.
TEST(GyrFilter, OneSweepTeachesASlopeOnlyWhereHysteresisCannotBeIt) {
  const Vec3 slope = Vec3(0.03, 0.003, -0.03) * kRadPerDeg;
  const auto bias = [&](double temp_degC) { return Vec3((temp_degC - 25.0) * slope + Vec3(0.01, -0.01, 0.005)); };
  const TriadCalibration gyr = after_sweep(5.0, 45.0, bias).gyr;
  EXPECT_NEAR(gyr.bias_per_K[0], slope[0], 0.1 * std::abs(slope[0]));
  EXPECT_NEAR(gyr.bias_per_K[2], slope[2], 0.1 * std::abs(slope[2]));
  EXPECT_EQ(gyr.bias_per_K[1], 0.0);
  EXPECT_EQ(gyr.bias_per_K2[1], 0.0);
  EXPECT_LT((gyr.bias_at(45.0) - bias(45.0)).norm(), 0.02 * kRadPerDeg);
}

TEST(GyrFilter, ABowShapedBiasFollowsTemperatureThoughItsEndsAreLevel) {
  const auto bias = [](double temp_degC) {
    const double t = (temp_degC - 25.0) / 25.0;
    return Vec3(0.0, 0.0, (0.7 * t * t) * kRadPerDeg);
  };
  const TriadCalibration gyr = after_sweep(0.0, 50.0, bias).gyr;
  EXPECT_NEAR(gyr.bias_per_K2[2], 0.7 * kRadPerDeg / 625.0, 0.1 * 0.7 * kRadPerDeg / 625.0);
  EXPECT_EQ(gyr.bias_per_K2[0], 0.0);
}

}  // namespace
}  // namespace stillpoint::calib

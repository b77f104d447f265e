#include "calib_online/online_calibrator.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/so3.h"
#include "tests/calib_online/session.h"

namespace stillpoint::calib {
namespace {

using test::consumer_sensor;
using test::Session;

TEST(OnlineCalibrator, FindsAccelerometerAndGyroscopeFromRestAndTurns) {
  const test::SensorTruth truth = consumer_sensor();
  Session session(truth, 21);
  session.turns(60, 5);
  const CalibrationSnapshot& s = session.calibrator.snapshot();
  EXPECT_EQ(s.acc.status, CalibrationStatus::kOk);
  // 1 mg and 0.1 %: sixty attitudes with 0.02 m/s^2 over 400 samples leave a tenth of that; the floor of the model the
  // rest.
  EXPECT_LT((vec(s.acc.bias) - truth.b_acc).norm(), 0.01);
  EXPECT_LT((mat(s.acc.matrix) - truth.H_acc).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((s.gyr.bias_at(25) - truth.b_gyr).norm(), 2e-4);
  // Gravity alone: 60 turns of 88 deg, directions to 2 mrad, so 2e-3 / sqrt(60 / 9) a coefficient, times three.
  EXPECT_LT((mat(s.gyr.matrix) - truth.H_gyr).cwiseAbs().maxCoeff(), 3e-3) << mat(s.gyr.matrix);
}

TEST(OnlineCalibrator, PredictsTheErrorThatItHas) {
  // Mean of the squared normalised error of the bias over seeds, three degrees of freedom.
  double nees = 0.0;
  constexpr int kSeeds = 30;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(1000 + seed);
    std::normal_distribution<double> normal;
    test::SensorTruth truth;
    truth.b_acc = 0.3 * Vec3(normal(random), normal(random), normal(random));
    Session session(truth, seed);
    session.turns(8, seed);
    const TriadCalibration& acc = session.calibrator.snapshot().acc;
    const Vec3 e = vec(acc.bias) - truth.b_acc;
    nees += e.dot(mat(acc.bias_covariance).inverse() * e) / kSeeds;
  }
  // The model keeps room for wander and temperature that this sensor does not have: never above 3, by chance 3 + 3 *
  // 0.45.
  EXPECT_LT(nees, 4.4);
  EXPECT_GT(nees, 0.05);
}

TEST(OnlineCalibrator, CutAndResumedGivesTheUncutResult) {
  Session session(consumer_sensor(), 4);
  session.turns(20, 9);
  OnlineCalibrator uncut({}, {}), first({}, {}), second({}, {});
  const std::size_t half = session.windows.size() / 2;
  for (const Window& w : session.windows) uncut.absorb(w);
  for (std::size_t k = 0; k < half; ++k) first.absorb(session.windows[k]);
  ASSERT_TRUE(second.restore(first.state()));
  for (std::size_t k = half; k < session.windows.size(); ++k) second.absorb(session.windows[k]);
  EXPECT_LT((vec(uncut.snapshot().acc.bias) - vec(second.snapshot().acc.bias)).norm(), 1e-9);
  EXPECT_EQ(uncut.snapshot().version, second.snapshot().version);
}

TEST(OnlineCalibrator, RefusesAStateThatIsNotFinite) {
  OnlineCalibrator calibrator({}, {});
  OnlineCalibrator::State state = calibrator.state();
  state.acc.published.x[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(calibrator.restore(state));
  state = calibrator.state();
  ++state.version;
  EXPECT_FALSE(calibrator.restore(state));
}

TEST(OnlineCalibrator, OneDirectionIsNotObservableAndNeverWorseThanThePrior) {
  test::SensorTruth truth = consumer_sensor();
  Session session(truth, 8);
  session.live(120.0);
  const TriadCalibration& acc = session.calibrator.snapshot().acc;
  EXPECT_EQ(acc.status, CalibrationStatus::kNotObservable);
  EXPECT_GT(acc.norm_sd, 0.1);  // five sixths of the sphere are as unknown as before
}

TEST(OnlineCalibrator, AnotherSensorIsNoticedAndLearntAnew) {
  Session session(consumer_sensor(), 31);
  session.turns(30, 2);
  session.source.truth().b_acc = Vec3(-0.9, 0.8, 0.5);  // 100 mg away
  session.turns(60, 3);
  const TriadCalibration& acc = session.calibrator.snapshot().acc;
  EXPECT_LT((vec(acc.bias) - Vec3(-0.9, 0.8, 0.5)).norm(), 0.03);
}

/// Windows in a row in one attitude share what the slope of the bias makes of a temperature cell's width (T14).
TEST(OnlineCalibrator, ARunInOneAttitudeTellsACellLessThanTheSameWindowsApart) {
  std::vector<Vec3> up;  // the middles of a cube's edges: all nine numbers show
  for (const double a : {-1.0, 1.0})
    for (const double b : {-1.0, 1.0}) up.insert(up.end(), {Vec3(a, b, 0), Vec3(0, a, b), Vec3(b, 0, a)});
  const auto norm_sd = [&](std::size_t in_a_row, bool cells) {
    OnlineCalibratorParams params;
    params.temperature_model = cells ? "cells" : "none";
    params.accelerometer.wander_sd_mps2 = 1e-3;
    OnlineCalibrator calibrator(params, CalibrationSnapshot{});
    for (std::size_t k = 0; k < 120; ++k) {
      Window w;
      w.t_end_ns = static_cast<std::int64_t>(k + 1) * 60'000'000'000;
      w.has = kAcc | kTemp;
      w.temp_degC = 22.0;
      w.acc_mps2 =
          array(Vec3(kStandardGravity_mps2 * up[k / in_a_row % up.size()].normalized() + Vec3(0.1, 0.05, -0.08)));
      w.acc_cov = array(Mat3(1e-6 * Mat3::Identity()));
      calibrator.absorb(w);
    }
    return calibrator.snapshot().acc.norm_sd;
  };
  EXPECT_GT(norm_sd(10, true), 1.5 * norm_sd(1, true));
  EXPECT_NEAR(norm_sd(10, false), norm_sd(1, false), 0.05 * norm_sd(1, false));  // without cells there is no slope
}

}  // namespace
}  // namespace stillpoint::calib

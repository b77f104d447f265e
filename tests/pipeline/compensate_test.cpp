#include "pipeline/compensate_stage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stillpoint::pipeline {
namespace {

CalibratedSample sample(const Vec3& acc, const Vec3& gyr, double temp_degC, std::int64_t t_ns = 0) {
  return {.t_ns = t_ns,
          .acc_mps2 = array(acc),
          .gyr_radps = array(gyr),
          .temp_degC = temp_degC,
          .has = kAcc | kGyr | kTemp};
}

TEST(Compensate, WithNothingToTakeOutChangesNoBit) {
  CompensateStage stage;
  CalibratedSample out;
  const auto in = sample({1.1, 2.2, 9.3}, {0.1, -0.2, 0.3}, 31.0);
  stage.process(in, out);
  EXPECT_EQ(out.acc_mps2, in.acc_mps2);
  EXPECT_EQ(out.gyr_radps, in.gyr_radps);
}

TEST(Compensate, TakesOutWhatTheCatalogueAdds) {
  const Vec3 f(3.0, -4.0, 8.0), w(0.5, -2.0, 1.0);
  const double tau = 12.0;
  Compensation c{.acc_per_K = {0.01, 0.02, -0.01},
                 .acc_per_K2 = {1e-4, 0, 0},
                 .acc_asym = {-1e-3, 2e-3, 1e-3},
                 .acc_quad = {1e-4, -2e-4, 1e-4},
                 .acc_cubic = {1e-4, 2e-5, -1e-5},
                 .gyr_per_K = {1e-3, 0, -1e-3},
                 .gyr_per_K2 = {0, -2e-5, 1e-5},
                 .gyr_asym = {2e-3, 1e-3, 0},
                 .gyr_cubic = {-1e-3, 1e-3, 2e-3},
                 .any = true};
  c.gyr_gsens << 1e-4, 2e-5, 0, 0, -1e-4, 0, 3e-5, 0, 1e-4;
  const auto cubed = [](const Vec3& v) { return Vec3(v.array().cube()); };
  const Vec3 u_f = f + tau * c.acc_per_K + tau * tau * c.acc_per_K2 + c.acc_asym.cwiseProduct(f.cwiseAbs()) +
                   c.acc_quad.cwiseProduct(f.cwiseProduct(f)) + c.acc_cubic.cwiseProduct(cubed(f));
  const Vec3 u_w = w + tau * c.gyr_per_K + tau * tau * c.gyr_per_K2 + c.gyr_gsens * f +
                   c.gyr_asym.cwiseProduct(w.cwiseAbs()) + c.gyr_cubic.cwiseProduct(cubed(w));
  CompensateStage stage(c);
  CalibratedSample out;
  stage.process(sample(u_f, u_w, 25.0 + tau), out);
  // Four passes of a correction of at most 2 % leave 2 % to the fifth power.
  EXPECT_LT((vec(out.acc_mps2) - f).norm(), 1e-6);
  EXPECT_LT((vec(out.gyr_radps) - w).norm(), 1e-9);
}

Compensation with_laws(std::vector<TakenOutLaw> laws) {
  Compensation c;
  c.laws = std::make_shared<const std::vector<TakenOutLaw>>(std::move(laws));
  c.any = true;
  return c;
}

TEST(Compensate, TakesOutLawsOfOneSensorAndOfTwo) {
  const Vec3 f(3.0, -4.0, 8.0), w(0.5, -2.0, 1.0);
  const auto own = [](const Momentary& now) -> Vec3 { return 1e-3 * now.force * now.force.norm(); };
  const auto coupled = [](const Momentary& now) -> Vec3 { return 1e-5 * now.force * (now.temp_degC - 25.0); };
  CompensateStage stage(with_laws({{&Momentary::force, own}, {&Momentary::rate, coupled}}));
  const Vec3 u_f = f + 1e-3 * f * f.norm(), u_w = w + 1e-5 * f * 12.0;
  CalibratedSample out;
  stage.process(sample(u_f, u_w, 37.0), out);
  EXPECT_LT((vec(out.acc_mps2) - f).norm(), 1e-5);
  EXPECT_LT((vec(out.gyr_radps) - w).norm(), 1e-8);
}

TEST(Compensate, ALawThatHasNoValueAtAReadingAddsNothing) {
  CompensateStage stage(
      with_laws({{&Momentary::rate, [](const Momentary& now) -> Vec3 { return now.rate / now.rate.norm(); }}}));
  const auto in = sample({0, 0, 9.8}, Vec3::Zero(), 25.0);
  CalibratedSample out;
  stage.process(in, out);
  EXPECT_EQ(out.gyr_radps, in.gyr_radps);
}

TEST(Compensate, ALawDoesNotReachTheCalibrationThroughARestWindow) {
  const auto law = [](const Momentary& now) -> Vec3 { return 1e-4 * now.force * (now.temp_degC - 25.0); };
  const CompensateStage stage(with_laws({{&Momentary::rate, law}}));
  const CalibrationSnapshot live;
  const Vec3 f(0.0, 6.0, 7.8), bias(0.01, -0.02, 0.03);
  calib::Window window;
  window.has = kAcc | kGyr;
  window.temp_degC = 35.0;
  window.acc_mps2 = array(f);
  window.gyr_radps = array(Vec3(bias + 1e-4 * 10.0 * f));
  stage.compensate(window, live);
  EXPECT_LT((vec(window.gyr_radps) - bias).norm(), 1e-12);
}

TEST(Compensate, MovesTheSpecificForceFromTheSensorToTheReferencePoint) {
  const Vec3 r(0.1, -0.05, 0.2), spin(0.0, 0.0, 4.0), at_reference(0.0, 0.0, 9.8);
  CompensateStage stage({.acc_lever_m = r, .any = true});
  CalibratedSample out;
  const Vec3 at_sensor = at_reference + spin.cross(spin.cross(r));  // a steady turn: no angular acceleration
  for (int k = 0; k < 3; ++k) stage.process(sample(at_sensor, spin, 25.0, k * 10'000'000), out);
  EXPECT_LT((vec(out.acc_mps2) - at_reference).norm(), 1e-12);
}

TEST(Compensate, TakesOutWhatTheLeverArmMakesOfASpinThatGrows) {
  const Vec3 r(0.1, -0.05, 0.2), grows(2.0, -1.0, 3.0), at_reference(0.5, 0.0, 9.8);
  CompensateStage stage({.acc_lever_m = r, .any = true});
  CalibratedSample out;
  const auto at_sensor = [&](double t_s) {
    const Vec3 spin = t_s * grows;
    return sample(at_reference + grows.cross(r) + spin.cross(spin.cross(r)), spin, 25.0, std::llround(1e9 * t_s));
  };
  for (const double t_s : {0.50, 0.51, 0.52}) stage.process(at_sensor(t_s), out);
  EXPECT_LT((vec(out.acc_mps2) - at_reference).norm(), 1e-9);
  // Over a pause the rates say nothing of the angular acceleration now: it stays in.
  stage.process(at_sensor(0.72), out);
  EXPECT_LT((vec(out.acc_mps2) - at_reference - grows.cross(r)).norm(), 1e-9);
}

TEST(Compensate, ARateWithoutAForceIsCorrectedWithTheForceBefore) {
  const Vec3 f(1.0, -2.0, 9.5), w(0.5, -2.0, 1.0);
  Compensation c{.any = true};
  c.gyr_gsens.diagonal() << 1e-3, 2e-3, -1e-3;
  CompensateStage stage(c);
  CalibratedSample out;
  stage.process(sample(f, Vec3::Zero(), 25.0), out);
  CalibratedSample alone = sample({NAN, NAN, NAN}, w + c.gyr_gsens * f, 25.0, 10'000'000);
  alone.has = kGyr;
  stage.process(alone, out);
  EXPECT_LT((vec(out.gyr_radps) - w).norm(), 1e-12);
}

TEST(Compensate, TakesTheMagnetometersDriftWithTemperatureOutOfReadingsWindowsAndTurns) {
  const Vec3 field(12.0, -20.0, 40.0), turned(-20.0, -12.0, 40.0);
  const double tau = -8.0;
  const Compensation c{.mag_per_K = {0.3, -0.2, 0.1}, .any = true};
  const Vec3 drift = tau * c.mag_per_K;
  CompensateStage stage(c);
  CalibratedSample out, in{.mag_uT = array(Vec3(field + drift)), .temp_degC = 25.0 + tau, .has = kMag | kTemp};
  stage.process(in, out);
  EXPECT_LT((vec(out.mag_uT) - field).norm(), 1e-12);

  CalibrationSnapshot live;
  live.mag.matrix = {1.02, 0.01, 0, 0.03, 0.98, 0, 0, -0.02, 1.01};
  live.mag.bias = {3.0, -1.0, 2.0};
  const auto raw = [&live](const Vec3& u) {
    return array(Vec3(Mat3(mat(live.mag.matrix)).inverse() * u + vec(live.mag.bias)));
  };
  calib::Window window;
  window.has = kMag;
  window.temp_degC = 25.0 + tau;
  window.mag_uT = raw(field + drift);
  stage.compensate(window, live);
  EXPECT_LT((vec(window.mag_uT) - vec(raw(field))).norm(), 1e-12);
  calib::FieldTurn turn{.temp_degC = 25.0 + tau, .before_uT = raw(field + drift), .after_uT = raw(turned + drift)};
  stage.compensate(turn, live);
  EXPECT_LT((vec(turn.before_uT) - vec(raw(field))).norm(), 1e-12);
  EXPECT_LT((vec(turn.after_uT) - vec(raw(turned))).norm(), 1e-12);
}

TEST(Compensate, AFieldThatArrivesLateIsTurnedOnWithTheBody) {
  const Vec3 axis = Vec3(1.0, -2.0, 2.0) / 3.0, field_world(0.0, 20.0, -43.0);
  const double rate = 3.0, delay_s = 0.02, now_s = 0.7;
  const auto in_body = [&](double t_s) { return Vec3(Eigen::AngleAxisd(-rate * t_s, axis) * field_world); };
  CompensateStage stage({.mag_delay_s = delay_s, .any = true});
  CalibratedSample out, in = sample({0.0, 0.0, 9.8}, rate * axis, 25.0);
  in.mag_uT = array(in_body(now_s - delay_s));
  in.has |= kMag;
  stage.process(in, out);
  EXPECT_LT((vec(out.mag_uT) - in_body(now_s)).norm(), 1e-9);
  in.has = kMag;  // nobody knows the rate
  stage.process(in, out);
  EXPECT_EQ(out.mag_uT, in.mag_uT);
}

TEST(Compensate, TheCalibrationLearnsFromWindowsWithoutTheEffectSoThatItIsNotSubtractedTwice) {
  const Vec3 bias(0.02, -0.01, 0.03), g(0.0, 0.0, 9.8);
  Compensation c{.gyr_per_K = {1e-3, 2e-3, -1e-3}, .any = true};
  c.gyr_gsens.diagonal() << 1e-4, 1e-4, 2e-4;
  CalibrationSnapshot live;
  live.gyr.matrix = {1.02, 0.01, 0, 0, 0.98, 0, 0, 0, 1.01};
  const double tau = 10.0;
  const Vec3 effect = tau * c.gyr_per_K + c.gyr_gsens * g;
  calib::Window window;
  window.has = kAcc | kGyr;
  window.temp_degC = 25.0 + tau;
  window.acc_mps2 = array(g);
  window.gyr_radps = array(Vec3(bias + Mat3(mat(live.gyr.matrix)).inverse() * effect));
  CompensateStage(c).compensate(window, live);
  EXPECT_LT((vec(window.gyr_radps) - bias).norm(), 1e-12);
}

}  // namespace
}  // namespace stillpoint::pipeline

#include "pipeline/compensate_stage.h"

#include <gtest/gtest.h>

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
                 .acc_cubic = {1e-4, 2e-5, -1e-5},
                 .gyr_per_K = {1e-3, 0, -1e-3},
                 .gyr_asym = {2e-3, 1e-3, 0},
                 .any = true};
  c.gyr_gsens << 1e-4, 2e-5, 0, 0, -1e-4, 0, 3e-5, 0, 1e-4;
  const Vec3 u_f =
      f + tau * c.acc_per_K + tau * tau * c.acc_per_K2 + c.acc_cubic.cwiseProduct(f.cwiseProduct(f).cwiseProduct(f));
  const Vec3 u_w = w + tau * c.gyr_per_K + c.gyr_gsens * f + c.gyr_asym.cwiseProduct(w.cwiseAbs());
  CompensateStage stage(c);
  CalibratedSample out;
  stage.process(sample(u_f, u_w, 25.0 + tau), out);
  // Four passes of a correction of at most 2 % leave 2 % to the fifth power.
  EXPECT_LT((vec(out.acc_mps2) - f).norm(), 1e-6);
  EXPECT_LT((vec(out.gyr_radps) - w).norm(), 1e-9);
}

TEST(Compensate, MovesTheSpecificForceFromTheSensorToTheReferencePoint) {
  const Vec3 r(0.1, -0.05, 0.2), spin(0.0, 0.0, 4.0), at_reference(0.0, 0.0, 9.8);
  CompensateStage stage({.acc_lever_m = r, .any = true});
  CalibratedSample out;
  const Vec3 at_sensor = at_reference + spin.cross(spin.cross(r));  // a steady turn: no angular acceleration
  for (int k = 0; k < 3; ++k) stage.process(sample(at_sensor, spin, 25.0, k * 10'000'000), out);
  EXPECT_LT((vec(out.acc_mps2) - at_reference).norm(), 1e-12);
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

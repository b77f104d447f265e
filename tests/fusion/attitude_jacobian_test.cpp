/// The derivatives that the covariance runs on, against differences of the motion itself.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/so3.h"
#include "core/units.h"
#include "fusion/error_state.h"
#include "fusion/heading_reading.h"

namespace stillpoint::fusion {
namespace {

constexpr int kSamples = 5;

/// All that the filter carries from sample to sample, as full quantities.
struct World {
  Quat q = exp_quat(Vec3(0.4, -0.7, 1.9));
  Vec3 velocity = Vec3::Zero(), position = Vec3::Zero();
  Vec3 gyr_bias{0.01, -0.02, 0.03}, acc_bias{0.1, 0.05, -0.07};
  Mat3 matrix = (Mat3() << 0.01, -0.004, 0.002, 0.003, -0.02, 0.005, -0.006, 0.001, 0.015).finished();
  double disturbance = 0.2;
};

const Vec3 kReading_radps(0.9, -1.4, 0.6), kForce_mps2(1.5, 3.0, 8.5);
constexpr double kDisturbanceTime_s = 10.0;

World moved(World w, double dt_s, MotionSums* sums = nullptr) {
  for (int i = 0; i < kSamples; ++i) {
    const Mat3 R = w.q.toRotationMatrix();
    const Vec3 force = R * (kForce_mps2 - w.acc_bias);
    if (sums != nullptr) {
      sums->time_s += dt_s;
      mat(sums->R) += R * dt_s;
      for (int j = 0; j < 3; ++j) mat(sums->R_rate[static_cast<std::size_t>(j)]) += R * (kReading_radps(j) * dt_s);
      vec(sums->force) += force * dt_s;
    }
    const Vec3 before = w.velocity;
    w.velocity += (force - Vec3(0, 0, kStandardGravity_mps2)) * dt_s;
    w.position += 0.5 * dt_s * (before + w.velocity);
    w.q = w.q * exp_quat((kReading_radps - w.matrix * kReading_radps - w.gyr_bias) * dt_s);
    w.disturbance *= std::exp(-dt_s / kDisturbanceTime_s);
  }
  return w;
}

World with_error(World w, const ErrorVector& e) {
  w.q = exp_quat(e.segment<3>(kTheta)) * w.q;
  w.velocity += e.segment<3>(kVelocity);
  w.position += e.segment<3>(kPosition);
  w.gyr_bias += e.segment<3>(kGyrBias);
  w.acc_bias += e.segment<3>(kAccBias);
  w.matrix += Eigen::Map<const Mat3>(e.data() + kGyrMatrix);
  w.disturbance += e(kDisturbance);
  return w;
}

ErrorVector between(const World& truth, const World& estimate) {
  ErrorVector e;
  e.segment<3>(kTheta) = log_quat(truth.q * estimate.q.conjugate());
  // (A4a) In a world that is turned by the heading's own error.
  const Mat3 turned = exp_so3(Vec3(0.0, 0.0, e(kTheta + 2)));
  e.segment<3>(kVelocity) = truth.velocity - turned * estimate.velocity;
  e.segment<3>(kPosition) = truth.position - turned * estimate.position;
  e.segment<3>(kGyrBias) = truth.gyr_bias - estimate.gyr_bias;
  e.segment<3>(kAccBias) = truth.acc_bias - estimate.acc_bias;
  Eigen::Map<Mat3>(e.data() + kGyrMatrix) = truth.matrix - estimate.matrix;
  e(kDisturbance) = truth.disturbance - estimate.disturbance;
  return e;
}

ErrorMatrix by_differences(double dt_s) {
  constexpr double kStep = 1e-6;
  ErrorMatrix F;
  const World estimate = moved({}, dt_s);
  for (int k = 0; k < kErrorStates; ++k) {
    const ErrorVector e = kStep * ErrorVector::Unit(k);
    F.col(k) =
        (between(moved(with_error({}, e), dt_s), estimate) - between(moved(with_error({}, -e), dt_s), estimate)) /
        (2.0 * kStep);
  }
  return F;
}

ErrorMatrix of_filter(double dt_s) {
  MotionSums sums;
  moved({}, dt_s, &sums);
  ProcessNoise none;
  none.disturbance_time_s = kDisturbanceTime_s;
  ErrorMatrix F;
  for (int k = 0; k < kErrorStates; ++k) {  // the iron's share goes through F and through nothing else
    ErrorState state;
    state.by_iron().col(0) = ErrorVector::Unit(k);
    state.propagate(sums, none);
    F.col(k) = state.by_iron().col(0);
  }
  return F;
}

TEST(AttitudeJacobian, PropagationIsTheDerivativeOfTheMotion) {
  // First order within a period: halving the period divides what is left by four, in every column.
  const ErrorMatrix whole = of_filter(2e-3) - by_differences(2e-3), half = of_filter(1e-3) - by_differences(1e-3);
  for (int k = 0; k < kErrorStates; ++k) {
    EXPECT_LT(half.col(k).norm(), 0.3 * whole.col(k).norm() + 1e-8) << "state " << k;
    EXPECT_LT(whole.col(k).norm(), 0.12 * (by_differences(2e-3).col(k) - ErrorVector::Unit(k)).norm() + 1e-7) << k;
  }
}

TEST(AttitudeJacobian, TheCovarianceGoesWithTheSameDerivative) {
  MotionSums sums;
  moved({}, 1e-3, &sums);
  ProcessNoise none;
  none.disturbance_time_s = kDisturbanceTime_s;
  ErrorState state;
  const ErrorVector sd = ErrorVector::LinSpaced(0.1, 2.0);
  state.start(sd);
  state.propagate(sums, none);
  const ErrorMatrix F = of_filter(1e-3);
  EXPECT_LT((state.P() - F * sd.cwiseAbs2().asDiagonal() * F.transpose()).norm(), 1e-12);
}

TEST(AttitudeJacobian, AHeadingHangsOnTiltAndIronAsItsDerivativeSays) {
  const Mat3 R = exp_so3(Vec3(0.5, -0.8, 2.1));
  const Vec3 place(3.0, 17.0, -41.0), iron(4.0, -2.0, 5.0);
  const Vec3 seen = place + R * iron;
  const auto error = [&](const Vec3& theta, const Vec3& of_iron) {
    // The estimate is turned from the truth by exp(-theta), and takes a wrong iron out.
    const Mat3 turn = exp_so3(Vec3(-theta));
    return HeadingReading::of(turn * seen - turn * R * (iron - of_iron), turn * R, 0.1).error_rad;
  };
  const HeadingReading reading = HeadingReading::of(place, R, 0.1);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const Vec3 step = kStep * Vec3::Unit(i);
    const double by_tilt = (error(step, Vec3::Zero()) - error(-step, Vec3::Zero())) / (2.0 * kStep);
    EXPECT_NEAR(by_tilt, i < 2 ? -reading.lean(i) : 1.0, 1e-7) << i;
    const double by_iron = (error(Vec3::Zero(), step) - error(Vec3::Zero(), -step)) / (2.0 * kStep);
    EXPECT_NEAR(by_iron, reading.iron(i), 1e-7) << i;
  }
}

TEST(AttitudeJacobian, AnUpdateIsThatOfTheGaussian) {
  // Against the formula of two dense matrices, for a measurement of several states at once.
  ErrorState state;
  state.start(ErrorVector::LinSpaced(0.1, 2.0));
  const ErrorMatrix before = state.P();
  ErrorVector h = ErrorVector::Zero();
  h(kTheta) = -0.4, h(kTheta + 2) = 1.0, h(kDisturbance) = 1.0;
  state.update(h, 0.3, 0.05);
  const double s = h.dot(before * h) + 0.05;
  EXPECT_LT((state.P() - (before - before * h * h.transpose() * before / s)).norm(), 1e-12);
  EXPECT_LT((state.take_mean() - before * h * (0.3 / s)).norm(), 1e-12);
}

TEST(AttitudeJacobian, WhatAnUpdateDoesNotTeachStaysAndTheCovarianceIsThatOfTheGain) {
  // Joseph's form, (I - k h') P (I - k h')' + k r k', holds for any gain.
  ErrorState state;
  state.start(ErrorVector::LinSpaced(0.1, 2.0));
  for (int i = 0; i < 3; ++i) state.depend(kTheta + i, 0.2 * ErrorVector::Unit(kGyrBias + i));
  const ErrorMatrix before = state.P();
  ErrorVector h = ErrorVector::Zero(), taught = ErrorVector::Ones();
  h(kTheta) = -0.4, h(kTheta + 2) = 1.0;
  taught.segment<3>(kGyrBias).setZero();
  state.update(h, 0.3, 0.05, Vec3::Zero(), taught);
  const ErrorVector gain = taught.cwiseProduct(before * h) / (h.dot(before * h) + 0.05);
  const ErrorMatrix left = ErrorMatrix::Identity() - gain * h.transpose();
  EXPECT_LT((state.P() - (left * before * left.transpose() + 0.05 * gain * gain.transpose())).norm(), 1e-12);
  EXPECT_EQ(state.mean().segment<3>(kGyrBias), Vec3::Zero());
  EXPECT_GT(std::abs(state.mean()(kTheta + 2)), 0.01);
}

}  // namespace
}  // namespace stillpoint::fusion

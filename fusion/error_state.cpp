#include "fusion/error_state.h"

#include <cmath>

#include "core/so3.h"

namespace stillpoint::fusion {

void ErrorState::start(const ErrorVector& sd) noexcept {
  P() = ErrorMatrix(sd.cwiseAbs2().asDiagonal());
  mean_.fill(0.0);
  untold_.fill(0.0);
  by_gyr_matrix().middleRows<kOfGyrMatrix>(kGyrMatrix).setIdentity();
  by_jump_.fill(0.0);
  pull_ = {};
}

void ErrorState::propagate(const MotionSums& sums, const ProcessNoise& noise) noexcept {
  Eigen::Map<ErrorMatrix> cov = P();
  const double T = sums.time_s;
  const Mat3 R_t = mat(sums.R).transpose();
  // Velocity and position are errors in a world that is turned by the heading's own error (A4a).
  const Eigen::Matrix<double, 2, 3> force = skew(vec(sums.force)).topRows<2>();
  Eigen::Matrix<double, 9, 3> R_rate_t;
  for (int j = 0; j < 3; ++j) R_rate_t.middleRows<3>(3 * j) = mat(sums.R_rate[static_cast<std::size_t>(j)]).transpose();
  const double keep = std::exp(-T / noise.disturbance_time_s);

  // M F', in place, as F differs from the identity in few rows: position first (it uses the old velocity), then
  // velocity, rotation. By columns, which lie one after the other in memory.
  const auto times_F_t = [&](auto&& M) {
    // Lazy products: Eigen's other ones copy, and for 25 by 9 it would take the blocked one, made for large matrices.
    const auto velocity =
        (M.template middleCols<3>(kAccBias).lazyProduct(R_t) - M.template middleCols<2>(kTheta).lazyProduct(force))
            .eval();
    M.template middleCols<3>(kPosition) += T * (M.template middleCols<3>(kVelocity) - 0.5 * velocity);
    M.template middleCols<3>(kVelocity) -= velocity;
    M.template middleCols<3>(kTheta) -= M.template middleCols<3>(kGyrBias).lazyProduct(R_t) +
                                        M.template middleCols<9>(kGyrMatrix).lazyProduct(R_rate_t);
    M.col(kDisturbance) *= keep;
  };
  times_F_t(cov);
  cov.transposeInPlace();
  times_F_t(cov);
  times_F_t(untold().transpose());
  times_F_t(by_jump().transpose());

  cov.block<3, 3>(kTheta, kTheta) += mat(noise.theta_rad2);
  const double gyr_walk = noise.gyr_bias_walk * noise.gyr_bias_walk * T;
  const double acc_walk = noise.acc_bias_walk * noise.acc_bias_walk * T;
  cov.block<3, 3>(kVelocity, kVelocity) += mat(noise.velocity_m2ps2);
  for (int i = 0; i < 3; ++i) {
    cov(kGyrBias + i, kGyrBias + i) += gyr_walk;
    cov(kAccBias + i, kAccBias + i) += acc_walk;
  }
  cov(kDisturbance, kDisturbance) += (1.0 - keep * keep) * noise.disturbance_rad * noise.disturbance_rad;
  cov.triangularView<Eigen::StrictlyUpper>() = cov.transpose();  // equal but for the last bits
}

void ErrorState::correct(const ErrorVector& gain, const ErrorVector& Ph, const Innovation& v) noexcept {
  P().noalias() -= gain * Ph.transpose();
  Eigen::Map<ErrorVector>(mean_.data()) += gain * v.value;
  pull_.add(gain.head<3>() * v.value, gain.head<3>().cwiseProduct(Ph.head<3>()));
  untold().noalias() -= gain * v.untold;
  by_jump().noalias() -= gain * v.by_jump;
}

void ErrorState::correct_in_part(const ErrorVector& gain, const ErrorVector& Ph, const Innovation& v) noexcept {
  correct(gain, Ph, v);
  P().noalias() -= (Ph - v.variance * gain) * gain.transpose();
}

ErrorState::Innovation ErrorState::innovation(int index, double z, double variance) const noexcept {
  return {z - mean()(index), P()(index, index) + variance, untold().row(index), by_jump().row(index)};
}

void ErrorState::weigh_jumps(const Innovation& v) noexcept {
  for (int i = 0; i < kJumps; ++i)
    evidence_[static_cast<std::size_t>(i)].add(v.by_jump.segment<3>(3 * i), v.value, v.variance);
}

void ErrorState::update(const ErrorVector& h, double z, double variance, const Vec3& iron,
                        const ErrorVector& taught) noexcept {
  const ErrorVector Ph = P() * h;
  Innovation v{z - h.dot(mean()), h.dot(Ph) + variance, h.transpose() * untold(), h.transpose() * by_jump()};
  v.untold.head<3>() += iron;
  if (!v.usable()) return;
  correct_in_part(taught.cwiseProduct(Ph) / v.variance, Ph, v);
  if (taught(kGyrBias) > 0.0) weigh_jumps(v);
}

void ErrorState::update(int index, double z, double variance) noexcept {
  const Innovation v = innovation(index, z, variance);
  if (!v.usable()) return;
  const ErrorVector Ph = P().col(index);
  correct(Ph / v.variance, Ph, v);
  weigh_jumps(v);
}

void ErrorState::begin_jump(int jump, int first) noexcept {
  auto columns = by_jump().middleCols<3>(3 * jump);
  columns.setZero();
  columns.middleRows<3>(first).setIdentity();
  evidence_[static_cast<std::size_t>(jump)] = {};
}

void ErrorState::believe_jump(int jump, const Vec3& size, const Mat3& covariance) noexcept {
  const Eigen::Matrix<double, kErrorStates, 3> done = by_jump().middleCols<3>(3 * jump);
  Eigen::Map<ErrorVector>(mean_.data()) += done * size;
  P() += (done * covariance).lazyProduct(done.transpose());
}

Mat3 ErrorState::unlearnt_rad2(const Array9& variances) const noexcept {
  const Eigen::Matrix<double, 3, kOfGyrMatrix> rotation = by_gyr_matrix().middleRows<3>(kTheta);
  const Eigen::Map<const Eigen::Matrix<double, kOfGyrMatrix, 1>> each(variances.data());
  return (rotation * each.asDiagonal()).lazyProduct(rotation.transpose());
}

double ErrorState::gyr_matrix_variance(int element, double unlearnt2) const noexcept {
  const int at = kGyrMatrix + element;
  const double own = by_gyr_matrix()(at, element);
  return P()(at, at) + unlearnt2 * own * own;
}

void ErrorState::learn_gyr_matrix(int element, double error, double variance, double unlearnt2) noexcept {
  const ErrorVector done = by_gyr_matrix().col(element);
  P() += unlearnt2 * done * done.transpose();
  by_gyr_matrix().col(element).setZero();
  update(kGyrMatrix + element, error, variance);
}

Mat3 ErrorState::iron_rad2(const Mat3& left_uT2) const noexcept {
  const auto rotation = by_iron().middleRows<3>(kTheta);
  return rotation.leftCols<3>() * left_uT2 * rotation.leftCols<3>().transpose() +
         rotation.col(3) * rotation.col(3).transpose();
}

void ErrorState::turn_back() noexcept {
  for (const int first : {static_cast<int>(kVelocity), static_cast<int>(kGyrBias)}) {
    P().middleRows<3>(first) *= -1.0;
    P().middleCols<3>(first) *= -1.0;
    untold().middleRows<3>(first) *= -1.0;
  }
}

void ErrorState::add_lean(double share, const Eigen::Vector2d& tilt_rad, const Eigen::Vector2d& velocity_mps) noexcept {
  ErrorVector lean = ErrorVector::Zero();
  lean.segment<2>(kTheta) = tilt_rad;
  lean.segment<2>(kVelocity) = velocity_mps;
  P().noalias() += share * lean * lean.transpose();
  for (int i = 0; i < 2; ++i) pull_.doubt(kTheta + i, share * tilt_rad(i) * tilt_rad(i));
}

void ErrorState::forget(int index, double variance) noexcept {
  P().row(index).setZero();
  P().col(index).setZero();
  P()(index, index) = variance;
  untold().row(index).setZero();
  if (const int element = index - kGyrMatrix; element >= 0 && element < kOfGyrMatrix)
    by_gyr_matrix()(index, element) = 1.0;
}

void ErrorState::depend(int index, const ErrorVector& weights) noexcept {
  const ErrorVector shared = P() * weights;
  P().row(index) += shared.transpose();
  P().col(index) += shared;
  P()(index, index) += weights.dot(shared);
  untold().row(index) += weights.transpose() * untold();
  by_jump().row(index) += weights.transpose() * by_jump();
}

void ErrorState::turn_world(const Mat3& by) noexcept {
  pull_.turn_world(by);
  for (const int block : {kTheta, kVelocity, kPosition}) {
    P().middleRows<3>(block) = (by * P().middleRows<3>(block)).eval();
    P().middleCols<3>(block) = (P().middleCols<3>(block) * by.transpose()).eval();
    untold().middleRows<3>(block) = (by * untold().middleRows<3>(block)).eval();
    by_jump().middleRows<3>(block) = (by * by_jump().middleRows<3>(block)).eval();
    Eigen::Map<ErrorVector> gathered(mean_.data());
    gathered.segment<3>(block) = (by * gathered.segment<3>(block)).eval();
  }
}

ErrorVector ErrorState::take_mean() noexcept {
  ErrorVector taken = mean();
  mean_.fill(0.0);
  return taken;
}

}  // namespace stillpoint::fusion

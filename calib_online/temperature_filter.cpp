#include "calib_online/temperature_filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace stillpoint::calib {
namespace {

/// (d, tau d, tau^2 d_7..9, d_7..9), T2.
AccFilter::StateVec acc_regressors(const Vec3& x, double tau) {
  AccFilter::StateVec h;
  const Vec9 d = quadric_terms(x);
  h << d, tau * d, tau * tau * d.tail<3>(), d.tail<3>();
  return h;
}

/// Rows: the nine entries at tau as a function of the state.
Eigen::Matrix<double, 9, AccFilter::kStates> acc_evaluation(double tau) {
  Eigen::Matrix<double, 9, AccFilter::kStates> G = Eigen::Matrix<double, 9, AccFilter::kStates>::Zero();
  G.leftCols<9>().setIdentity();
  G.middleCols<9>(9).diagonal().setConstant(tau);
  G.block<3, 3>(6, 18).diagonal().setConstant(tau * tau);
  G.block<3, 3>(6, 21).setIdentity();
  return G;
}

}  // namespace

AccFilter::AccFilter(const AccFilterParams& params, double gravity_mps2)
    : params_(params), gravity_mps2_(gravity_mps2) {
  reset();
}

AccFilter::StateVec AccFilter::prior_variance() const noexcept {
  StateVec v;
  const double g = gravity_mps2_;
  v.segment<3>(0).setConstant(squared(2.0 * params_.scale_sd));
  v.segment<3>(3).setConstant(squared(2.0 * params_.shear_sd));
  v.segment<3>(6).setConstant(squared(2.0 * params_.bias_sd_mps2 / g));
  v.segment<3>(9).setConstant(squared(2.0 * params_.matrix_per_25K_sd));
  v.segment<3>(12).setConstant(2.0 * squared(2.0 * params_.matrix_per_25K_sd));  // xy is the sum of two elements
  v.segment<3>(15).setConstant(squared(2.0 * params_.bias_per_K_sd_mps2 * kTempScale_K / g));
  v.segment<3>(18).setConstant(squared(2.0 * params_.bias_curvature_sd_mps2 / g));
  v.segment<3>(21).setConstant(squared(2.0 * params_.wander_sd_mps2 / g));
  return v;
}

void AccFilter::reset() noexcept {
  s_ = State{};
  s_.x[0] = s_.x[1] = s_.x[2] = 1.0;
  s_.P.set(prior_variance().asDiagonal());
}

void AccFilter::open(double relative) noexcept {
  Eigen::Matrix<double, kStates, kStates> P = s_.P.full();
  P.diagonal() += prior_variance();
  P.diagonal().segment<3>(0).array() += squared(2.0 * relative);
  P.diagonal().segment<3>(6).array() += squared(2.0 * relative);
  s_.P.set(P);
}

void AccFilter::predict(double dt_s) noexcept {
  if (!(dt_s > 0)) return;
  const double keep = std::exp(-dt_s / params_.wander_s);
  const double walk = squared(2.0 * params_.bias_walk_mps2_rts / gravity_mps2_) * dt_s;
  const double refill = squared(2.0 * params_.wander_sd_mps2 / gravity_mps2_) * (1.0 - keep * keep);
  Eigen::Matrix<double, kStates, kStates> P = s_.P.full();
  P.bottomRows<3>() *= keep;
  P.rightCols<3>() *= keep;
  for (std::size_t k = 21; k < 24; ++k) s_.x[k] *= keep;
  P.diagonal().segment<3>(6).array() += walk;
  P.diagonal().tail<3>().array() += refill;
  s_.P.set(P);
}

AccFilter::Innovation AccFilter::innovation(const Vec3& x, double tau) const noexcept {
  const StateVec h = acc_regressors(x, tau);
  const Eigen::Map<const StateVec> state(s_.x.data());
  return {1.0 - h.dot(state), h.dot(s_.P.full() * h)};
}

void AccFilter::update(const Vec3& x, double tau, double variance) noexcept {
  const StateVec h = acc_regressors(x, tau);
  Eigen::Matrix<double, kStates, kStates> P = s_.P.full();
  const StateVec Ph = P * h;
  const double S = h.dot(Ph) + variance;
  Eigen::Map<StateVec> state(s_.x.data());
  state += Ph * ((1.0 - h.dot(state)) / S);
  P.noalias() -= Ph * Ph.transpose() / S;
  // Rounding may take a variance below zero after very many windows; a floor of 1e-9 (a few ng) stops that.
  P.diagonal() = P.diagonal().cwiseMax(1e-18);
  s_.P.set(P);
}

Vec9 AccFilter::at(double tau) const noexcept { return acc_evaluation(tau) * Eigen::Map<const StateVec>(s_.x.data()); }

Mat9 AccFilter::covariance_at(double tau) const noexcept {
  const auto G = acc_evaluation(tau);
  return Mat9(G * s_.P.full() * G.transpose());
}

Mat9 AccFilter::prior_covariance_at(double tau) const noexcept {
  const auto G = acc_evaluation(tau);
  return Mat9(G * prior_variance().asDiagonal() * G.transpose());
}

GyrFilter::GyrFilter(const GyrFilterParams& params) : params_(params) { reset(); }

GyrFilter::StateVec GyrFilter::prior_variance() const noexcept {
  StateVec v = StateVec::Zero();
  for (int axis = 0; axis < 3; ++axis)
    v.segment<4>(4 * axis) << squared(params_.bias_sd_radps), squared(params_.bias_per_K_sd_radps * kTempScale_K),
        squared(params_.bias_curvature_sd_radps), squared(params_.wander_sd_radps);
  return v;
}

void GyrFilter::reset() noexcept {
  s_ = State{};
  s_.P.set(prior_variance().asDiagonal());
}

void GyrFilter::begin_attitude(const Mat3& turn_covariance) noexcept {
  StateMat P = s_.P.full();
  P.bottomRows<3>().setZero();
  P.rightCols<3>().setZero();
  P.bottomRightCorner<3, 3>() = turn_covariance;
  s_.P.set(P);
  for (std::size_t k = kBias; k < kStates; ++k) s_.x[k] = 0.0;
}

void GyrFilter::open_bias(double sd_radps) noexcept {
  StateMat P = s_.P.full();
  for (int axis = 0; axis < 3; ++axis) P(4 * axis, 4 * axis) += squared(sd_radps);
  s_.P.set(P);
}

void GyrFilter::predict(double dt_s) noexcept {
  if (!(dt_s > 0)) return;
  const double keep = std::exp(-dt_s / params_.wander_s);
  StateMat P = s_.P.full();
  for (int axis = 0; axis < 3; ++axis) {
    const int w = 4 * axis + 3;
    P.row(w) *= keep;
    P.col(w) *= keep;
    P(w, w) += squared(params_.wander_sd_radps) * (1.0 - keep * keep);
    P(4 * axis, 4 * axis) += squared(params_.bias_walk_radps_rts) * dt_s;
    s_.x[static_cast<std::size_t>(w)] *= keep;
  }
  s_.P.set(P);
}

Eigen::Matrix<double, GyrFilter::kStates, 3> GyrFilter::regressors(double tau, double tau2) noexcept {
  Eigen::Matrix<double, kStates, 3> h = Eigen::Matrix<double, kStates, 3>::Zero();
  for (int axis = 0; axis < 3; ++axis) h.block<4, 1>(4 * axis, axis) << 1.0, tau, tau2, 1.0;
  return h;
}

void GyrFilter::update(const Vec3& rate, const Mat3& covariance, double tau, double tau2) noexcept {
  auto h = regressors(tau, tau2);
  h.bottomRows<3>().setIdentity();
  StateMat P = s_.P.full();
  const Eigen::Matrix<double, kStates, 3> Ph = P * h;
  const Mat3 S = h.transpose() * Ph + covariance + squared(params_.mean_floor_radps) * Mat3::Identity();
  const Eigen::Matrix<double, kStates, 3> gain = Ph * S.inverse();
  Eigen::Map<StateVec> state(s_.x.data());
  state += gain * (rate - h.transpose() * state);
  P.noalias() -= gain * Ph.transpose();
  s_.P.set(StateMat(0.5 * (P + P.transpose())));
}

Vec3 GyrFilter::at(double tau, double tau2) const noexcept {
  return regressors(tau, tau2).transpose() * Eigen::Map<const StateVec>(s_.x.data());
}

Mat3 GyrFilter::covariance_at(double tau, double tau2) const noexcept {
  const auto h = regressors(tau, tau2);
  return h.transpose() * s_.P.full() * h;
}

std::array<bool, 3> GyrFilter::follows_temperature(double tau_min, double tau_max) const noexcept {
  const StateMat P = s_.P.full();
  const double hysteresis = params_.hysteresis_per_K_radps * kTempScale_K * (tau_max - tau_min);
  std::array<bool, 3> out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double b1 = s_.x[4 * axis + 1], b2 = s_.x[4 * axis + 2];
    const Eigen::Matrix2d P_b = P.block<2, 2>(static_cast<int>(4 * axis) + 1, static_cast<int>(4 * axis) + 1);
    // The extremes of a parabola over a range lie at its ends or at its vertex.
    const double vertex = b2 != 0.0 ? std::clamp(-0.5 * b1 / b2, tau_min, tau_max) : tau_min;
    const std::array<double, 3> at{tau_min, tau_max, vertex};
    for (const double from : at)
      for (const double to : at) {
        const Eigen::Vector2d d(to - from, to * to - from * from);
        const double change = d.dot(Eigen::Vector2d(b1, b2));
        out[axis] = out[axis] || squared(change) > 4.0 * (squared(hysteresis) + d.dot(P_b * d));
      }
  }
  return out;
}

Mat3 GyrFilter::polynomial() const noexcept {
  Mat3 c;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t k = 4 * static_cast<std::size_t>(axis);
    c.row(axis) << s_.x[k] + s_.x[k + 3], s_.x[k + 1], s_.x[k + 2];
  }
  return c;
}

}  // namespace stillpoint::calib

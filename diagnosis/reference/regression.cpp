#include "diagnosis/reference/regression.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

namespace stillpoint::diag {
namespace {

constexpr int kProfileRounds = 3;
constexpr double kShortestWalkPeriod_s = 8.0;
constexpr int kMostWalkTerms = 40;

struct AxisSystem {
  Eigen::MatrixXd design;            // whitened: nuisance, columns, walk
  std::vector<Eigen::Index> global;  // index of each design column among all unknowns
  Series rhs;
};

/// Prior precision of the walk's coefficient k (1-based): a walk with q unit/sqrt(s) has variance 2 q^2 T / (k pi)^2
/// there.
double walk_variance(double q, int k, double duration_s) {
  const double root = static_cast<double>(k) * std::numbers::pi;
  return 2.0 * q * q * duration_s / (root * root);
}

AxisSystem whitened_system(const Target& t, const Columns& columns, const NoiseModel& noise, int axis, bool with_walk) {
  AxisSystem out;
  const auto p = static_cast<Eigen::Index>(columns.size());
  std::vector<Series> parts;
  for (Eigen::Index j = 0; j < t.nuisance.cols(); ++j) {
    parts.push_back(noise.whiten(t.layout, t.nuisance.col(j), axis));
    out.global.push_back(axis * t.nuisance.cols() + j);
  }
  for (Eigen::Index j = 0; j < p; ++j) {
    const auto shown = shown_in(columns[static_cast<std::size_t>(j)], axis);
    if (!shown) continue;
    parts.push_back(noise.whiten(t.layout, *shown, axis));
    out.global.push_back(3 * t.nuisance.cols() + j);
  }
  if (with_walk) {
    for (Eigen::Index j = 0; j < t.walk.cols(); ++j) {
      parts.push_back(noise.whiten(t.layout, t.walk.col(j), axis));
      out.global.push_back(3 * t.nuisance.cols() + p + axis * t.walk.cols() + j);
    }
  }
  out.design.resize(t.layout.n, static_cast<Eigen::Index>(parts.size()));
  for (std::size_t j = 0; j < parts.size(); ++j) out.design.col(static_cast<Eigen::Index>(j)) = parts[j];
  out.rhs = noise.whiten(t.layout, t.residual.col(axis), axis);
  return out;
}

Series3 remove(const Target& t, const Columns& columns, const Eigen::VectorXd& x) {
  Series3 left = t.residual;
  const Eigen::Index z = t.nuisance.cols();
  const auto p = static_cast<Eigen::Index>(columns.size());
  for (int axis = 0; axis < 3; ++axis) {
    left.col(axis) -= t.nuisance * x.segment(axis * z, z);
    for (Eigen::Index j = 0; j < p; ++j) {
      const Column& c = columns[static_cast<std::size_t>(j)];
      if (c.axis < 0) left.col(axis) -= x[3 * z + j] * c.x.col(axis);
      if (c.axis == axis) left.col(axis) -= x[3 * z + j] * c.x.col(0);
    }
    if (x.size() > 3 * z + p) left.col(axis) -= t.walk * x.segment(3 * z + p + axis * t.walk.cols(), t.walk.cols());
  }
  return left;
}

/// The q of one axis that makes what is left most likely, among a geometric grid and 0.
double best_walk(const Target& t, const NoiseModel& noise, const Series& leftover, int axis) {
  const Eigen::Index K = t.walk.cols();
  Eigen::MatrixXd C(t.layout.n, K);
  for (Eigen::Index j = 0; j < K; ++j) C.col(j) = noise.whiten(t.layout, t.walk.col(j), axis);
  const Series r = noise.whiten(t.layout, leftover, axis);
  const Eigen::MatrixXd G = C.transpose() * C;
  const Eigen::VectorXd g = C.transpose() * r;
  const double unit = noise.innovation_sd(axis) / std::sqrt(t.duration_s);
  double best_q = 0.0, best = 0.0;
  for (double q = 0.003 * unit; q < 300.0 * unit; q *= 2.0) {
    Eigen::VectorXd d(K);
    for (Eigen::Index k = 0; k < K; ++k) d[k] = std::sqrt(walk_variance(q, static_cast<int>(k) + 1, t.duration_s));
    const Eigen::MatrixXd M = Eigen::MatrixXd::Identity(K, K) + d.asDiagonal() * G * d.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> llt(M);
    const Eigen::VectorXd dg = d.cwiseProduct(g);
    const double log_det = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
    const double gain = 0.5 * dg.dot(llt.solve(dg)) - 0.5 * log_det;
    if (gain > best) best = gain, best_q = q;
  }
  return best_q;
}

}  // namespace

Eigen::MatrixXd walk_basis(const Signals& s) {
  const double length = s.duration_s();
  const int terms = std::clamp(static_cast<int>(2.0 * length / kShortestWalkPeriod_s), 4, kMostWalkTerms);
  Eigen::MatrixXd walk(s.n, terms);
  for (int k = 1; k <= terms; ++k) walk.col(k - 1) = (s.t_s.array() * (k * std::numbers::pi / length)).cos();
  return walk;
}

Target make_target(const Signals& s, Sensor sensor) {
  Target t;
  t.sensor = sensor;
  t.layout = make_layout(s, sensor);
  t.residual = s.residual[sensor];
  t.nuisance.resize(s.n, 4);
  t.nuisance.col(0).setOnes();
  t.nuisance.rightCols<3>() = s.vector[sensor];
  t.duration_s = s.duration_s();
  t.dt_s = s.dt_s;
  return t;
}

Fit fit_with(const Target& t, const Columns& columns, const NoiseModel& noise, const std::array<double, 3>& walk_q) {
  const Eigen::Index z = t.nuisance.cols();
  const auto p = static_cast<Eigen::Index>(columns.size());
  const bool with_walk = t.walk.cols() > 0 && (walk_q[0] > 0 || walk_q[1] > 0 || walk_q[2] > 0);
  const Eigen::Index K = with_walk ? t.walk.cols() : 0;
  const Eigen::Index unknowns = 3 * z + p + 3 * K;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns);
  double log_det = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem a = whitened_system(t, columns, noise, axis, with_walk);
    const Eigen::MatrixXd local = a.design.transpose() * a.design;
    const Eigen::VectorXd local_g = a.design.transpose() * a.rhs;
    for (std::size_t i = 0; i < a.global.size(); ++i) {
      g[a.global[i]] += local_g[static_cast<Eigen::Index>(i)];
      for (std::size_t j = 0; j < a.global.size(); ++j)
        G(a.global[i], a.global[j]) += local(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
    if (!with_walk) continue;
    const Eigen::Index first = 3 * z + p + axis * K;
    const double q = std::max(walk_q[static_cast<std::size_t>(axis)], 1e-9 * noise.innovation_sd(axis));
    Eigen::VectorXd d(K);
    for (Eigen::Index k = 0; k < K; ++k) d[k] = std::sqrt(walk_variance(q, static_cast<int>(k) + 1, t.duration_s));
    const Eigen::MatrixXd M =
        Eigen::MatrixXd::Identity(K, K) + d.asDiagonal() * G.block(first, first, K, K) * d.asDiagonal();
    log_det += 2.0 * Eigen::LLT<Eigen::MatrixXd>(M).matrixLLT().diagonal().array().log().sum();
    for (Eigen::Index k = 0; k < K; ++k) G(first + k, first + k) += 1.0 / (d[k] * d[k]);
  }
  // Unknowns have wildly different units; the system is solved with a unit diagonal, and a whisper of ridge against
  // exact copies.
  const Eigen::VectorXd scale = G.diagonal().cwiseMax(1e-280).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd S = scale.asDiagonal() * G * scale.asDiagonal();
  S.diagonal().array() += 1e-10;
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(S);
  const Eigen::VectorXd x = scale.cwiseProduct(ldlt.solve(scale.cwiseProduct(g)));
  const Eigen::MatrixXd inverse = scale.asDiagonal() * ldlt.solve(Eigen::MatrixXd::Identity(unknowns, 3 * z + p));
  Fit fit;
  fit.theta = x.segment(3 * z, p);
  fit.covariance = inverse.block(3 * z, 3 * z, p, p) * scale.segment(3 * z, p).asDiagonal();
  fit.nuisance = x.head(3 * z);
  fit.nuisance_covariance = inverse.topLeftCorner(3 * z, 3 * z) * scale.head(3 * z).asDiagonal();
  fit.leftover = remove(t, columns, x);
  fit.whitened.resize(t.layout.n, 3);
  for (int axis = 0; axis < 3; ++axis) fit.whitened.col(axis) = noise.whiten(t.layout, fit.leftover.col(axis), axis);
  double penalty = 0.0;
  if (with_walk)
    for (int axis = 0; axis < 3; ++axis)
      for (Eigen::Index k = 0; k < K; ++k) {
        const double q = std::max(walk_q[static_cast<std::size_t>(axis)], 1e-9 * noise.innovation_sd(axis));
        const double c = x[3 * z + p + axis * K + k];
        penalty += c * c / walk_variance(q, static_cast<int>(k) + 1, t.duration_s);
      }
  fit.log_likelihood = noise.log_scale_sum() - 0.5 * (fit.whitened.squaredNorm() + penalty + log_det);
  fit.walk_q = walk_q;
  return fit;
}

Fit fit_profile(const Target& t, const Columns& columns) {
  // The start is least squares under white noise. An autoregression of the residual itself would take offset and trend
  // for memory, whiten them away, and never find back to what explains them.
  Target white = t;
  white.walk.resize(0, 0);
  white.layout.order = 0;
  Fit fit = fit_with(white, columns, NoiseModel(white.layout, white.residual), {0.0, 0.0, 0.0});
  std::array<double, 3> q{};
  for (int round = 0; round < kProfileRounds; ++round) {
    const NoiseModel noise(t.layout, fit.leftover);
    if (t.walk.cols() > 0) {
      // The walk is judged on the residual with the fitted walk put back.
      const Fit bare = fit_with(t, columns, noise, {0.0, 0.0, 0.0});
      for (int axis = 0; axis < 3; ++axis)
        q[static_cast<std::size_t>(axis)] = best_walk(t, noise, bare.leftover.col(axis), axis);
    }
    fit = fit_with(t, columns, noise, q);
  }
  // The last likelihood belongs to the noise of the last fit but one; by now they agree to a fraction of a nat.
  return fit;
}

}  // namespace stillpoint::diag

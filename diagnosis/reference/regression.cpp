#include "diagnosis/reference/regression.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "diagnosis/reference/slow_columns.h"

namespace stillpoint::diag {
namespace {

constexpr int kProfileRounds = 3;
constexpr int kMostWalkTerms = 40;
constexpr double kScoreBlock_s = 1.0;                     // longer than a camera's noise remembers
constexpr double kLeastBlocksPerNumber = 3.0;             // fewer do not know a covariance
constexpr double kAnotherSolution = 10.0;                 // nats
constexpr double kWeakWalk = 0.003, kStrongWalk = 300.0;  // where a walk's rate is sought, in walk_unit

/// One axis, whitened, as normal equations: nuisance and columns first, the walk last, so that the model without a walk
/// is the top left corner.
struct AxisSystem {
  Eigen::MatrixXd design;  // nuisance and columns
  SlowColumns walk;
  std::vector<Eigen::Index> global;  // index of each column of design and walk among all unknowns
  Eigen::Index plain = 0;            // columns of the design
  Series rhs;
  Eigen::MatrixXd gram;    // of design and walk
  Eigen::VectorXd moment;  // the same with rhs
};
using Systems = std::array<AxisSystem, 3>;

AxisSystem whitened_system(const Target& t, const Columns& columns, const NoiseModel& noise, int axis) {
  AxisSystem out;
  const auto p = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index z = t.nuisance.cols();
  std::vector<Series> shown;
  for (Eigen::Index j = 0; j < z; ++j) out.global.push_back(axis * z + j);
  for (Eigen::Index j = 0; j < p; ++j) {
    auto x = shown_in(columns[static_cast<std::size_t>(j)], axis);
    if (!x) continue;
    shown.push_back(std::move(*x));
    out.global.push_back(3 * z + j);
  }
  out.plain = static_cast<Eigen::Index>(out.global.size());
  for (Eigen::Index j = 0; j < t.walk.cols(); ++j) out.global.push_back(3 * z + p + axis * t.walk.cols() + j);
  out.design.resize(t.layout.n, out.plain);
  for (Eigen::Index j = 0; j < out.plain; ++j)
    out.design.col(j) = j < z ? noise.whiten(t.layout, t.nuisance.col(j), axis)
                              : noise.whiten(t.layout, shown[static_cast<std::size_t>(j - z)], axis);
  out.walk = SlowColumns(t.layout, t.walk, noise, axis);
  out.rhs = noise.whiten(t.layout, t.residual.col(axis), axis);
  const Eigen::Index K = t.walk.cols();
  out.gram.resize(out.plain + K, out.plain + K);
  out.gram.topLeftCorner(out.plain, out.plain) = out.design.transpose() * out.design;
  out.moment.resize(out.plain + K);
  out.moment.head(out.plain) = out.design.transpose() * out.rhs;
  if (K == 0) return out;
  out.gram.bottomLeftCorner(K, out.plain) = out.walk.products(out.design);
  out.gram.topRightCorner(out.plain, K) = out.gram.bottomLeftCorner(K, out.plain).transpose();
  out.gram.bottomRightCorner(K, K) = out.walk.gram();
  out.moment.tail(K) = out.walk.products(out.rhs);
  return out;
}

Systems whitened_systems(const Target& t, const Columns& columns, const NoiseModel& noise) {
  return {whitened_system(t, columns, noise, 0), whitened_system(t, columns, noise, 1),
          whitened_system(t, columns, noise, 2)};
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

/// The rate of a walk that strays as far within the recording as one sample scatters.
double walk_unit(const Target& t, const NoiseModel& noise, int axis) {
  return noise.innovation_sd(axis) / std::sqrt(t.duration_s);
}

/// The q of one axis that makes most likely what `without`, the fit with no walk, leaves over: among a geometric grid
/// and 0.
double best_walk(const Target& t, const NoiseModel& noise, const AxisSystem& a, const Eigen::VectorXd& without,
                 int axis) {
  const Eigen::Index K = t.walk.cols();
  const Eigen::MatrixXd G = a.gram.bottomRightCorner(K, K);
  const Eigen::VectorXd g = a.moment.tail(K) - a.gram.bottomLeftCorner(K, a.plain) * without;
  const double unit = walk_unit(t, noise, axis);
  double best_q = 0.0, best = 0.0;
  for (double q = kWeakWalk * unit; q < kStrongWalk * unit; q *= 2.0) {
    const Eigen::VectorXd d = walk_deviations(t, q);
    const Eigen::MatrixXd M = Eigen::MatrixXd::Identity(K, K) + d.asDiagonal() * G * d.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> llt(M);
    const Eigen::VectorXd dg = d.cwiseProduct(g);
    const double log_det = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
    const double gain = 0.5 * dg.dot(llt.solve(dg)) - 0.5 * log_det;
    if (gain > best) best = gain, best_q = q;
  }
  return best_q;
}

bool any_walks(const std::array<double, 3>& q) { return q[0] > 0 || q[1] > 0 || q[2] > 0; }

/// A walk that one axis does not need is pinned there.
double walk_of(const std::array<double, 3>& q, const NoiseModel& noise, int axis) {
  return std::max(q[static_cast<std::size_t>(axis)], 1e-9 * noise.innovation_sd(axis));
}

struct Solution {
  Eigen::VectorXd x;        // nuisance of the three axes, columns, walk of the three axes
  Eigen::MatrixXd inverse;  // of the normal matrix: all rows, the columns of nuisance and candidates
  double log_det = 0.0;     // of the walk, marginalised
};

Solution solve_normal(const Target& t, const Columns& columns, const NoiseModel& noise, const Systems& systems,
                      const std::array<double, 3>& walk_q) {
  const Eigen::Index z = t.nuisance.cols();
  const auto p = static_cast<Eigen::Index>(columns.size());
  const bool walks = t.walk.cols() > 0 && any_walks(walk_q);
  const Eigen::Index K = walks ? t.walk.cols() : 0;
  const Eigen::Index unknowns = 3 * z + p + 3 * K;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns);
  Solution out;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    const Eigen::Index used = a.plain + K;
    for (Eigen::Index i = 0; i < used; ++i) {
      const Eigen::Index row = a.global[static_cast<std::size_t>(i)];
      g[row] += a.moment[i];
      for (Eigen::Index j = 0; j < used; ++j) G(row, a.global[static_cast<std::size_t>(j)]) += a.gram(i, j);
    }
    if (!walks) continue;
    const Eigen::Index first = 3 * z + p + axis * K;
    const Eigen::VectorXd d = walk_deviations(t, walk_of(walk_q, noise, axis));
    const Eigen::MatrixXd M =
        Eigen::MatrixXd::Identity(K, K) + d.asDiagonal() * G.block(first, first, K, K) * d.asDiagonal();
    out.log_det += 2.0 * Eigen::LLT<Eigen::MatrixXd>(M).matrixLLT().diagonal().array().log().sum();
    G.diagonal().segment(first, K) += d.cwiseAbs2().cwiseInverse();
  }
  // Unknowns have wildly different units; the system is solved with a unit diagonal, and a whisper of ridge against
  // exact copies.
  const Eigen::VectorXd scale = G.diagonal().cwiseMax(1e-280).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd S = scale.asDiagonal() * G * scale.asDiagonal();
  S.diagonal().array() += 1e-10;
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(S);
  out.x = scale.cwiseProduct(ldlt.solve(scale.cwiseProduct(g)));
  out.inverse = scale.asDiagonal() * ldlt.solve(Eigen::MatrixXd::Identity(unknowns, 3 * z + p)) *
                scale.head(3 * z + p).asDiagonal();
  return out;
}

Fit solve(const Target& t, const Columns& columns, const NoiseModel& noise, const Systems& systems,
          const std::array<double, 3>& walk_q) {
  const Eigen::Index z = t.nuisance.cols();
  const auto p = static_cast<Eigen::Index>(columns.size());
  const Solution s = solve_normal(t, columns, noise, systems, walk_q);
  Fit fit;
  fit.theta = s.x.segment(3 * z, p);
  fit.covariance = s.inverse.block(3 * z, 3 * z, p, p);
  fit.nuisance = s.x.head(3 * z);
  fit.nuisance_covariance = s.inverse.topLeftCorner(3 * z, 3 * z);
  fit.leftover = remove(t, columns, s.x);
  fit.whitened.resize(t.layout.n, 3);
  double penalty = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    const bool walks = s.x.size() > 3 * z + p;
    Eigen::VectorXd own(a.plain + (walks ? t.walk.cols() : 0));
    for (Eigen::Index i = 0; i < own.size(); ++i) own[i] = s.x[a.global[static_cast<std::size_t>(i)]];
    fit.whitened.col(axis) = a.rhs - a.design * own.head(a.plain);
    if (!walks) continue;
    fit.whitened.col(axis) -= a.walk.times(own.tail(t.walk.cols()));
    penalty += own.tail(t.walk.cols()).cwiseQuotient(walk_deviations(t, walk_of(walk_q, noise, axis))).squaredNorm();
  }
  fit.log_likelihood = noise.log_scale_sum() - 0.5 * (fit.whitened.squaredNorm() + penalty + s.log_det);
  fit.walk_q = walk_q;
  return fit;
}

}  // namespace

Series3 contribution_of(const Columns& columns, const Eigen::VectorXd& theta, Eigen::Index n) {
  Series3 effect = Series3::Zero(n, 3);
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (int axis = 0; axis < 3; ++axis)
      if (const auto shown = shown_in(columns[j], axis))
        effect.col(axis) += theta[static_cast<Eigen::Index>(j)] * *shown;
  return effect;
}

Eigen::MatrixXd walk_basis(const Series& t_s, double duration_s, double shortest_period_s) {
  const int terms = std::clamp(static_cast<int>(2.0 * duration_s / shortest_period_s), 4, kMostWalkTerms);
  Eigen::MatrixXd walk(t_s.size(), terms);
  walk.col(0) = (t_s.array() * (std::numbers::pi / duration_s)).cos();
  walk.col(1) = 2.0 * walk.col(0).array().square() - 1.0;
  for (int k = 2; k < terms; ++k)  // cos (k + 1) x = 2 cos x cos k x - cos (k - 1) x
    walk.col(k) = 2.0 * walk.col(0).cwiseProduct(walk.col(k - 1)) - walk.col(k - 2);
  return walk;
}

Eigen::VectorXd walk_deviations(const Target& t, double q) {
  Eigen::VectorXd d(t.walk.cols());
  for (Eigen::Index k = 0; k < d.size(); ++k)
    d[k] = q * std::sqrt(2.0 * t.duration_s) / (static_cast<double>(k + 1) * std::numbers::pi);
  return d;
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
  t.rows = s.rows;
  return t;
}

Fit fit_with(const Target& t, const Columns& columns, const NoiseModel& noise, const std::array<double, 3>& walk_q) {
  if (t.walk.cols() == 0 || any_walks(walk_q))
    return solve(t, columns, noise, whitened_systems(t, columns, noise), walk_q);
  Target still = t;
  still.walk.resize(0, 0);
  return solve(still, columns, noise, whitened_systems(still, columns, noise), walk_q);
}

Eigen::MatrixXd robust_covariance(const Target& t, const Columns& columns, const NoiseModel& noise,
                                  const std::array<double, 3>& walk_q) {
  const auto p = static_cast<Eigen::Index>(columns.size());
  const bool walks = t.walk.cols() > 0 && any_walks(walk_q);
  const Systems systems = whitened_systems(t, columns, noise);
  const Solution s = solve_normal(t, columns, noise, systems, walk_q);
  const auto block = std::max<Eigen::Index>(1, std::lround(kScoreBlock_s / t.rows.step_s));
  const Eigen::Index blocks = (t.layout.n + block - 1) / block;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(blocks, s.x.size());
  Eigen::VectorXd speaks = Eigen::VectorXd::Zero(blocks);
  for (const AxisSystem& a : systems) {
    const Eigen::Index used = a.plain + (walks ? t.walk.cols() : 0);
    Eigen::MatrixXd design(t.layout.n, used);
    design.leftCols(a.plain) = a.design;
    if (walks) design.rightCols(t.walk.cols()) = a.walk.times(Eigen::MatrixXd::Identity(t.walk.cols(), t.walk.cols()));
    Eigen::VectorXd own(used);
    for (Eigen::Index i = 0; i < used; ++i) own[i] = s.x[a.global[static_cast<std::size_t>(i)]];
    const Series left = a.rhs - design * own;
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const Eigen::Index begin = b * block, length = std::min(block, t.layout.n - begin);
      const auto rows = design.middleRows(begin, length);
      for (Eigen::Index i = 0; i < used; ++i)
        scores(b, a.global[static_cast<std::size_t>(i)]) += rows.col(i).dot(left.segment(begin, length));
      speaks[b] += rows.middleCols(t.nuisance.cols(), a.plain - t.nuisance.cols()).squaredNorm();
    }
  }
  const auto n = static_cast<double>((speaks.array() > 1e-3 * speaks.maxCoeff()).count());
  if (n < kLeastBlocksPerNumber * static_cast<double>(p)) return {};
  const Eigen::MatrixXd influence = scores * s.inverse.rightCols(p);
  return influence.transpose() * influence * (n / (n - static_cast<double>(p)));
}

Fit fit_walking(const Target& t, const Columns& columns, const NoiseModel& noise) {
  const Systems systems = whitened_systems(t, columns, noise);
  std::array<double, 3> q{};
  if (t.walk.cols() == 0) return solve(t, columns, noise, systems, q);
  // The walk is judged on the residual with the fitted walk put back.
  const Eigen::VectorXd bare = solve_normal(t, columns, noise, systems, q).x;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    Eigen::VectorXd own(a.plain);
    for (Eigen::Index i = 0; i < a.plain; ++i) own[i] = bare[a.global[static_cast<std::size_t>(i)]];
    q[static_cast<std::size_t>(axis)] = best_walk(t, noise, a, own, axis);
  }
  return solve(t, columns, noise, systems, q);
}

Fit fit_profile(const Target& t, const Columns& columns) {
  // The start is least squares under white noise. An autoregression of the residual itself would take offset and trend
  // for memory, whiten them away, and never find back to what explains them.
  Target white = t;
  white.layout.order = 0;
  const auto by_turns = [&](Fit fit) {
    for (int round = 0; round < kProfileRounds; ++round)
      fit = fit_walking(t, columns, NoiseModel(t.layout, fit.leftover));
    // The last likelihood belongs to the noise of the last fit but one; by now they agree to a fraction of a nat.
    return fit;
  };
  const NoiseModel level(white.layout, white.residual);
  Fit fit = by_turns(fit_with(white, columns, level, {}));
  if (!any_walks(fit.walk_q)) return fit;
  // The same holds of a strong walk: it is half taken for memory, and a law that follows it somewhat would gain by
  // what the walk lost. So it is also started from a fit that leaves no drift over. After three rounds two starts of
  // one solution differ by some nats either way; another solution is better by more.
  std::array<double, 3> strong{};
  for (int axis = 0; axis < 3; ++axis) strong[static_cast<std::size_t>(axis)] = kStrongWalk * walk_unit(t, level, axis);
  Fit second = by_turns(fit_with(white, columns, level, strong));
  return second.log_likelihood > fit.log_likelihood + kAnotherSolution ? second : fit;
}

}  // namespace stillpoint::diag

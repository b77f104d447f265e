#include "diagnosis/reference/regression.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "diagnosis/reference/normal_equations.h"

namespace stillpoint::diag {
namespace {

constexpr int kProfileRounds = 3;
constexpr int kMostWalkTerms = 40;
constexpr double kScoreBlock_s = 1.0;                     // longer than a camera's noise remembers
constexpr double kLeastBlocksPerNumber = 3.0;             // fewer do not know a covariance
constexpr double kAnotherSolution = 10.0;                 // nats
constexpr double kWeakWalk = 0.003, kStrongWalk = 300.0;  // where a walk's rate is sought, in walk_unit

/// The rate of a walk that strays as far within the recording as one sample scatters.
double walk_unit(const Target& t, const NoiseModel& noise, int axis) {
  return noise.innovation_sd(axis) / std::sqrt(t.duration_s);
}

/// The q of one axis that makes most likely what `without`, the fit with no walk, leaves over: among a geometric grid
/// and 0.
double best_walk(const Target& t, const NoiseModel& noise, const AxisSystem& a, const Eigen::VectorXd& without,
                 int axis) {
  const Eigen::Index K = t.walk_terms();
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

Fit fit_of(const Problem& of, const Systems& systems, const Solution& s, const std::array<double, 3>& walk_q) {
  const auto p = static_cast<Eigen::Index>(of.columns.size());
  const Eigen::Index own = 3 * of.own();
  Fit fit;
  fit.theta = s.x.segment(own, p);
  fit.covariance = s.inverse.block(own, own, p, p);
  fit.nuisance = s.x.head(own);
  fit.nuisance_covariance = s.inverse.topLeftCorner(own, own);
  fit.leftover = leftover_of(of, s);
  fit.whitened.resize(of.t.layout.n, 3);
  const Eigen::Index K = of.walk_in(s.x);
  double penalty = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    const Eigen::VectorXd x = s.of_axis(of, a, axis);
    fit.whitened.col(axis) = a.design.col(a.plain) - a.design.leftCols(a.plain) * x.head(a.plain);
    if (K == 0) continue;
    const auto walk = x.tail(K);
    fit.whitened.col(axis) -= a.walk.times(walk);
    penalty += walk.cwiseQuotient(walk_deviations(of.t, walk_of(walk_q, of.noise, axis))).squaredNorm();
  }
  fit.log_likelihood = of.noise.log_scale_sum() - 0.5 * (fit.whitened.squaredNorm() + penalty + s.log_det);
  fit.walk_q = walk_q;
  return fit;
}

/// Each axis walks at its most likely rate.
struct Walking {
  Systems systems;
  std::array<double, 3> q{};
  Solution solution;

  explicit Walking(const Problem& of) : systems(whitened_systems(of)), solution(solve_normal(of, systems, q)) {
    if (of.walk() == 0) return;
    // The walk is judged on the residual with the fitted walk put back.
    for (int axis = 0; axis < 3; ++axis) {
      const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
      q[static_cast<std::size_t>(axis)] =
          best_walk(of.t, of.noise, a, solution.of_axis(of, a, axis).head(a.plain), axis);
    }
    if (any_walks(q)) solution = solve_normal(of, systems, q);
  }
};

}  // namespace

Series3 contribution_of(const Columns& columns, const Eigen::VectorXd& theta, Eigen::Index n) {
  Series3 effect = Series3::Zero(n, 3);
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (int axis = 0; axis < 3; ++axis)
      if (const auto shown = shown_in(columns[j], axis))
        effect.col(axis) += theta[static_cast<Eigen::Index>(j)] * *shown;
  return effect;
}

WalkBasis walk_basis(const Series& t_s, double duration_s, double shortest_period_s) {
  const int terms = std::clamp(static_cast<int>(2.0 * duration_s / shortest_period_s), 4, kMostWalkTerms);
  Eigen::MatrixXd walk(t_s.size(), terms);
  walk.col(0) = (t_s.array() * (std::numbers::pi / duration_s)).cos();
  walk.col(1) = 2.0 * walk.col(0).array().square() - 1.0;
  for (int k = 2; k < terms; ++k)  // cos (k + 1) x = 2 cos x cos k x - cos (k - 1) x
    walk.col(k) = 2.0 * walk.col(0).cwiseProduct(walk.col(k - 1)) - walk.col(k - 2);
  return std::make_shared<const Eigen::MatrixXd>(std::move(walk));
}

Eigen::VectorXd walk_deviations(const Target& t, double q) {
  Eigen::VectorXd d(t.walk_terms());
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
  const Problem of{t, t.layout, columns, noise, any_walks(walk_q)};
  const Systems systems = whitened_systems(of);
  return fit_of(of, systems, solve_normal(of, systems, walk_q), walk_q);
}

Eigen::MatrixXd robust_covariance(const Target& t, const Columns& columns, const NoiseModel& noise,
                                  const std::array<double, 3>& walk_q) {
  const auto p = static_cast<Eigen::Index>(columns.size());
  const Problem of{t, t.layout, columns, noise, any_walks(walk_q)};
  const Systems systems = whitened_systems(of);
  const Solution s = solve_normal(of, systems, walk_q);
  const Eigen::Index K = of.walk_in(s.x);
  const auto block = std::max<Eigen::Index>(1, std::lround(kScoreBlock_s / t.rows.step_s));
  const Eigen::Index blocks = (t.layout.n + block - 1) / block;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(blocks, s.x.size());
  Eigen::VectorXd speaks = Eigen::VectorXd::Zero(blocks);
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    const Eigen::VectorXd x = s.of_axis(of, a, axis);
    const auto design = a.design.leftCols(a.plain);
    Series left = a.design.col(a.plain) - design * x.head(a.plain);
    Eigen::MatrixXd walk;
    if (K > 0) {
      walk = a.walk.times(Eigen::MatrixXd::Identity(K, K));
      left -= walk * x.tail(K);
    }
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const Eigen::Index begin = b * block, length = std::min(block, t.layout.n - begin);
      const auto rows = design.middleRows(begin, length);
      const Eigen::VectorXd score = rows.transpose() * left.segment(begin, length);
      for (Eigen::Index i = 0; i < a.plain; ++i) scores(b, a.global[static_cast<std::size_t>(i)]) += score[i];
      if (K > 0)
        scores.row(b).segment(of.plain() + axis * K, K) +=
            (walk.middleRows(begin, length).transpose() * left.segment(begin, length)).transpose();
      speaks[b] += rows.rightCols(a.plain - of.own()).squaredNorm();
    }
  }
  const auto n = static_cast<double>((speaks.array() > 1e-3 * speaks.maxCoeff()).count());
  if (n < kLeastBlocksPerNumber * static_cast<double>(p)) return {};
  const Eigen::MatrixXd influence = scores * s.inverse.rightCols(p);
  return influence.transpose() * influence * (n / (n - static_cast<double>(p)));
}

Fit fit_walking(const Target& t, const Columns& columns, const NoiseModel& noise) {
  const Problem of{t, t.layout, columns, noise};
  const Walking w(of);
  return fit_of(of, w.systems, w.solution, w.q);
}

Fit fit_profile(const Target& t, const Columns& columns) {
  // The start is least squares under white noise. An autoregression of the residual itself would take offset and trend
  // for memory, whiten them away, and never find back to what explains them.
  Layout white = t.layout;
  white.order = 0;
  const NoiseModel level(white, t.residual);
  const auto from = [&](const std::array<double, 3>& walk_q) {
    const Problem start{t, white, columns, level, any_walks(walk_q)};
    Series3 left = leftover_of(start, solve_normal(start, whitened_systems(start), walk_q));
    for (int round = 1; round < kProfileRounds; ++round) {
      const NoiseModel noise(t.layout, left);
      const Problem of{t, t.layout, columns, noise};
      left = leftover_of(of, Walking(of).solution);
    }
    // The last likelihood belongs to the noise of the last fit but one; by now they agree to a fraction of a nat.
    return fit_walking(t, columns, NoiseModel(t.layout, left));
  };
  Fit fit = from({});
  if (!any_walks(fit.walk_q)) return fit;
  // The same holds of a strong walk: it is half taken for memory, and a law that follows it somewhat would gain by
  // what the walk lost. So it is also started from a fit that leaves no drift over. After three rounds two starts of
  // one solution differ by some nats either way; another solution is better by more.
  std::array<double, 3> strong{};
  for (int axis = 0; axis < 3; ++axis) strong[static_cast<std::size_t>(axis)] = kStrongWalk * walk_unit(t, level, axis);
  Fit second = from(strong);
  return second.log_likelihood > fit.log_likelihood + kAnotherSolution ? second : fit;
}

}  // namespace stillpoint::diag

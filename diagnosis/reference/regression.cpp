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

/// What is fitted, under which noise; without the walk where none is wanted. `layout`: the target's, or a whiter one.
struct Problem {
  const Target& t;
  const Layout& layout;
  const Columns& columns;
  const NoiseModel& noise;
  bool may_walk = true;
  [[nodiscard]] Eigen::Index own() const { return t.nuisance.cols(); }  // unknowns of one axis: offset and matrix
  [[nodiscard]] Eigen::Index plain() const { return 3 * own() + static_cast<Eigen::Index>(columns.size()); }
  [[nodiscard]] Eigen::Index walk() const { return may_walk ? t.walk_terms() : 0; }
};

/// One axis, whitened, as normal equations: nuisance and columns first, the walk last, so that the model without a walk
/// is the top left corner.
struct AxisSystem {
  Eigen::MatrixXd design;  // nuisance and columns; the last is the residual
  SlowColumns walk;
  std::vector<Eigen::Index> global;  // index of each column of the design among all unknowns
  Eigen::Index plain = 0;            // columns of the design but for the residual
  Eigen::MatrixXd gram;              // of design and walk
  Eigen::VectorXd moment;            // the same with the residual
};
using Systems = std::array<AxisSystem, 3>;

AxisSystem whitened_system(const Problem& of, int axis) {
  AxisSystem out;
  const Eigen::Index z = of.own(), K = of.walk();
  for (Eigen::Index j = 0; j < z; ++j) out.global.push_back(axis * z + j);
  for (std::size_t j = 0; j < of.columns.size(); ++j)
    if (shown_in(of.columns[j], axis)) out.global.push_back(3 * z + static_cast<Eigen::Index>(j));
  out.plain = static_cast<Eigen::Index>(out.global.size());
  out.design.resize(of.t.layout.n, out.plain + 1);
  const auto whiten = [&](const Eigen::Ref<const Series>& x) { return of.noise.whiten(of.layout, x, axis); };
  for (Eigen::Index j = 0; j < z; ++j) out.design.col(j) = whiten(of.t.nuisance.col(j));
  for (Eigen::Index j = z; j < out.plain; ++j) {
    const auto column = static_cast<std::size_t>(out.global[static_cast<std::size_t>(j)] - 3 * z);
    out.design.col(j) = whiten(*shown_in(of.columns[column], axis));
  }
  out.design.col(out.plain) = whiten(of.t.residual.col(axis));
  const Eigen::MatrixXd products = out.design.transpose() * out.design;
  out.gram.resize(out.plain + K, out.plain + K);
  out.moment.resize(out.plain + K);
  out.gram.topLeftCorner(out.plain, out.plain) = products.topLeftCorner(out.plain, out.plain);
  out.moment.head(out.plain) = products.col(out.plain).head(out.plain);
  if (K == 0) return out;
  out.walk = SlowColumns(of.layout, *of.t.walk, of.noise, axis);
  const Eigen::MatrixXd beside = out.walk.products(out.design);
  out.gram.bottomLeftCorner(K, out.plain) = beside.leftCols(out.plain);
  out.gram.topRightCorner(out.plain, K) = beside.leftCols(out.plain).transpose();
  out.gram.bottomRightCorner(K, K) = out.walk.gram();
  out.moment.tail(K) = beside.col(out.plain);
  return out;
}

Systems whitened_systems(const Problem& of) {
  return {whitened_system(of, 0), whitened_system(of, 1), whitened_system(of, 2)};
}

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

bool any_walks(const std::array<double, 3>& q) { return q[0] > 0 || q[1] > 0 || q[2] > 0; }

/// A walk that one axis does not need is pinned there.
double walk_of(const std::array<double, 3>& q, const NoiseModel& noise, int axis) {
  return std::max(q[static_cast<std::size_t>(axis)], 1e-9 * noise.innovation_sd(axis));
}

struct Solution {
  Eigen::VectorXd x;        // nuisance of the three axes, columns, walk of the three axes
  Eigen::MatrixXd inverse;  // of the normal matrix: all rows, the columns of nuisance and candidates
  double log_det = 0.0;     // of the walk, marginalised
  [[nodiscard]] Eigen::Index walk(const Problem& of) const { return x.size() > of.plain() ? of.walk() : 0; }
  /// Of one axis: as the design has them, then its walk.
  [[nodiscard]] Eigen::VectorXd of_axis(const Problem& of, const AxisSystem& a, int axis) const {
    Eigen::VectorXd own(a.plain + walk(of));
    for (Eigen::Index i = 0; i < a.plain; ++i) own[i] = x[a.global[static_cast<std::size_t>(i)]];
    own.tail(walk(of)) = x.segment(of.plain() + axis * walk(of), walk(of));
    return own;
  }
};

/// One axis' walk in the normal equations: it meets the others only through what the axis shows.
struct WalkBlock {
  Eigen::LLT<Eigen::MatrixXd> llt;
  Eigen::MatrixXd with_plain;  // plain unknowns x K
  Eigen::VectorXd moment;
};

Solution solve_normal(const Problem& of, const Systems& systems, const std::array<double, 3>& walk_q) {
  constexpr double kRidge = 1e-10;  // a whisper against exact copies
  const bool walks = of.walk() > 0 && any_walks(walk_q);
  const Eigen::Index K = walks ? of.walk() : 0, plain = of.plain();
  Solution out;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(plain, plain);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(plain);
  for (const AxisSystem& a : systems)
    for (Eigen::Index i = 0; i < a.plain; ++i) {
      const Eigen::Index row = a.global[static_cast<std::size_t>(i)];
      g[row] += a.moment[i];
      for (Eigen::Index j = 0; j < a.plain; ++j) G(row, a.global[static_cast<std::size_t>(j)]) += a.gram(i, j);
    }
  // Unknowns have wildly different units; the system is solved with a unit diagonal.
  const auto units_of = [](const auto& diagonal) {
    return diagonal.cwiseMax(1e-280).cwiseSqrt().cwiseInverse().eval();
  };
  Eigen::VectorXd scale(plain + 3 * K);
  scale.head(plain) = units_of(G.diagonal());
  const auto of_plain = scale.head(plain);
  Eigen::MatrixXd S = of_plain.asDiagonal() * G * of_plain.asDiagonal();
  S.diagonal().array() += kRidge;
  Eigen::VectorXd right = of_plain.cwiseProduct(g);
  std::array<WalkBlock, 3> blocks;
  for (int axis = 0; walks && axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    WalkBlock& w = blocks[static_cast<std::size_t>(axis)];
    const Eigen::VectorXd d = walk_deviations(of.t, walk_of(walk_q, of.noise, axis));
    Eigen::MatrixXd own = a.gram.bottomRightCorner(K, K);
    const Eigen::MatrixXd M = Eigen::MatrixXd::Identity(K, K) + d.asDiagonal() * own * d.asDiagonal();
    out.log_det += 2.0 * Eigen::LLT<Eigen::MatrixXd>(M).matrixLLT().diagonal().array().log().sum();
    own.diagonal() += d.cwiseAbs2().cwiseInverse();
    const auto units = scale.segment(plain + axis * K, K) = units_of(own.diagonal());
    own = units.asDiagonal() * own * units.asDiagonal();
    own.diagonal().array() += kRidge;
    w.llt.compute(own);
    w.with_plain = Eigen::MatrixXd::Zero(plain, K);
    for (Eigen::Index i = 0; i < a.plain; ++i)
      w.with_plain.row(a.global[static_cast<std::size_t>(i)]) = a.gram.row(i).tail(K);
    w.with_plain = of_plain.asDiagonal() * w.with_plain * units.asDiagonal();
    w.moment = units.cwiseProduct(a.moment.tail(K));
    S -= w.with_plain * w.llt.solve(w.with_plain.transpose());
    right -= w.with_plain * w.llt.solve(w.moment);
  }
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(S);
  out.x.resize(scale.size());
  out.inverse.resize(scale.size(), plain);
  out.x.head(plain) = ldlt.solve(right);
  out.inverse.topRows(plain) = ldlt.solve(Eigen::MatrixXd::Identity(plain, plain));
  for (int axis = 0; walks && axis < 3; ++axis) {
    const WalkBlock& w = blocks[static_cast<std::size_t>(axis)];
    out.x.segment(plain + axis * K, K) = w.llt.solve(w.moment - w.with_plain.transpose() * out.x.head(plain));
    out.inverse.middleRows(plain + axis * K, K) = -w.llt.solve(w.with_plain.transpose() * out.inverse.topRows(plain));
  }
  out.x = scale.cwiseProduct(out.x);
  out.inverse = scale.asDiagonal() * out.inverse * of_plain.asDiagonal();
  return out;
}

/// Residual minus everything fitted.
Series3 left_by(const Problem& of, const Solution& s) {
  const Eigen::Index z = of.own(), K = s.walk(of);
  Series3 left = of.t.residual - of.t.nuisance * s.x.head(3 * z).reshaped(z, 3);
  for (std::size_t j = 0; j < of.columns.size(); ++j) {
    const Column& c = of.columns[j];
    const double k = s.x[3 * z + static_cast<Eigen::Index>(j)];
    if (c.axis < 0)
      left -= k * c.x;
    else
      left.col(c.axis) -= k * c.x.col(0);
  }
  if (K > 0) left -= *of.t.walk * s.x.tail(3 * K).reshaped(K, 3);
  return left;
}

Fit fit_of(const Problem& of, const Systems& systems, const Solution& s, const std::array<double, 3>& walk_q) {
  const auto p = static_cast<Eigen::Index>(of.columns.size());
  const Eigen::Index own = 3 * of.own();
  Fit fit;
  fit.theta = s.x.segment(own, p);
  fit.covariance = s.inverse.block(own, own, p, p);
  fit.nuisance = s.x.head(own);
  fit.nuisance_covariance = s.inverse.topLeftCorner(own, own);
  fit.leftover = left_by(of, s);
  fit.whitened.resize(of.t.layout.n, 3);
  double penalty = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSystem& a = systems[static_cast<std::size_t>(axis)];
    const Eigen::VectorXd x = s.of_axis(of, a, axis);
    fit.whitened.col(axis) = a.design.col(a.plain) - a.design.leftCols(a.plain) * x.head(a.plain);
    if (s.walk(of) == 0) continue;
    const auto walk = x.tail(s.walk(of));
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
  const Eigen::Index K = s.walk(of);
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
    Series3 left = left_by(start, solve_normal(start, whitened_systems(start), walk_q));
    for (int round = 1; round < kProfileRounds; ++round) {
      const NoiseModel noise(t.layout, left);
      const Problem of{t, t.layout, columns, noise};
      left = left_by(of, Walking(of).solution);
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

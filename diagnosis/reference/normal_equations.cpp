#include "diagnosis/reference/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace stillpoint::diag {
namespace {

/// One axis' walk in the normal equations: it meets the others only through what the axis shows.
struct WalkBlock {
  Eigen::LLT<Eigen::MatrixXd> llt;
  Eigen::MatrixXd with_plain;  // plain unknowns x K
  Eigen::VectorXd moment;
};

}  // namespace

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

double walk_of(const std::array<double, 3>& q, const NoiseModel& noise, int axis) {
  return std::max(q[static_cast<std::size_t>(axis)], 1e-9 * noise.innovation_sd(axis));
}

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
    const Eigen::VectorXd units = units_of(own.diagonal());
    scale.segment(plain + axis * K, K) = units;
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

Series3 leftover_of(const Problem& of, const Eigen::VectorXd& x, Eigen::Index begin, Eigen::Index rows) {
  const Eigen::Index z = of.own(), K = of.walk_in(x);
  Series3 left =
      of.t.residual.middleRows(begin, rows) - of.t.nuisance.middleRows(begin, rows) * x.head(3 * z).reshaped(z, 3);
  for (std::size_t j = 0; j < of.columns.size(); ++j) {
    const Column& c = of.columns[j];
    const double k = x[3 * z + static_cast<Eigen::Index>(j)];
    if (c.axis < 0)
      left -= k * c.x.middleRows(begin, rows);
    else
      left.col(c.axis) -= k * c.x.col(0).segment(begin, rows);
  }
  if (K > 0) left -= of.t.walk->middleRows(begin, rows) * x.tail(3 * K).reshaped(K, 3);
  return left;
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/blocks_left_out.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "diagnosis/reference/normal_equations.h"

namespace stillpoint::diag {
namespace {

constexpr double kFree = 1e-6;  // of what the recording says of a coefficient: its prior

/// Normal equations of some rows, whitened.
struct Equations {
  Eigen::MatrixXd gram;
  Eigen::VectorXd score;
  double square = 0.0, counted = 0.0;

  explicit Equations(Eigen::Index numbers)
      : gram(Eigen::MatrixXd::Zero(numbers, numbers)), score(Eigen::VectorXd::Zero(numbers)) {}
  void add(const Equations& other, double times) {
    gram += times * other.gram, score += times * other.score;
    square += times * other.square, counted += times * other.counted;
  }
};

/// The likeliest coefficients, and the logarithm of the readings' density with all coefficients left open.
struct Told {
  Eigen::VectorXd coefficients;
  double evidence_nats = 0.0;
};

Told told_by(const Equations& e, double variance) {
  const Eigen::VectorXd scale = e.gram.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * e.gram * scale.asDiagonal());
  Eigen::VectorXd coefficients = scale.cwiseProduct(solver.solve(scale.cwiseProduct(e.score)));
  const double volume = solver.vectorD().cwiseAbs().array().log().sum() - 2.0 * scale.array().log().sum();
  const double misfit = (e.square - e.score.dot(coefficients)) / variance;
  return {std::move(coefficients), -0.5 * (misfit + e.counted * std::log(variance) + volume)};
}

/// Adds what an axis says, block by block.
void add_axis(const Problem& of, int axis, Eigen::Index block, std::vector<Equations>& to) {
  const AxisSystem a = whitened_system(of, axis);
  Eigen::Index begin = 0;
  for (Equations& own : to) {
    const Eigen::Index length = std::min(block, of.t.layout.n - begin);
    const auto rows = a.design.leftCols(a.plain).middleRows(begin, length);
    const auto y = a.design.col(a.plain).segment(begin, length);
    own.gram(a.global, a.global) += rows.transpose() * rows;
    own.score(a.global) += rows.transpose() * y;
    own.square += y.squaredNorm();
    own.counted += of.layout.counts.segment(begin, length).sum();
    begin += length;
  }
}

/// What every block says, and all of them with the prior.
struct OfBlocks {
  std::vector<Equations> each;
  Equations all;
  double variance = 1.0;  ///< of a whitened reading, as the best coefficients leave it, but at least 1
};

OfBlocks equations_of(const Problem& of, Eigen::Index block) {
  const auto blocks = static_cast<std::size_t>((of.layout.n + block - 1) / block);
  OfBlocks out{std::vector<Equations>(blocks, Equations(of.plain())), Equations(of.plain())};
  for (int axis = 0; axis < 3; ++axis) add_axis(of, axis, block, out.each);
  for (const Equations& own : out.each) out.all.add(own, 1.0);
  out.all.gram.diagonal() += (kFree * out.all.gram.diagonal().array() + 1e-280).matrix();
  const double misfit = out.all.square - out.all.score.dot(told_by(out.all, 1.0).coefficients);
  out.variance = std::max(1.0, misfit / std::max(out.all.counted, 1.0));
  return out;
}

}  // namespace

LeftOut blocks_left_out(const Target& t, const Columns& columns, const NoiseModel& noise, Eigen::Index block) {
  const Problem of{t, t.layout, columns, noise, false};
  const auto [of_block, all, variance] = equations_of(of, block);
  const auto blocks = static_cast<Eigen::Index>(of_block.size());
  const double whole = told_by(all, variance).evidence_nats;
  LeftOut out{Eigen::VectorXd(blocks), Series3(t.layout.n, 3)};
  for (Eigen::Index b = 0; b < blocks; ++b) {
    Equations others = all;
    others.add(of_block[static_cast<std::size_t>(b)], -1.0);
    const Told by_others = told_by(others, variance);
    out.nats[b] = whole - by_others.evidence_nats;
    const Eigen::Index begin = b * block, length = std::min(block, t.layout.n - begin);
    out.residual.middleRows(begin, length) = leftover_of(of, by_others.coefficients, begin, length);
  }
  return out;
}

Eigen::VectorXd excess_of_others(const Target& t, const Columns& columns, const NoiseModel& noise, Eigen::Index block,
                                 const std::vector<int>& fold_of_block) {
  const Problem of{t, t.layout, columns, noise, false};
  const auto [of_block, all, variance] = equations_of(of, block);
  std::vector<Equations> of_fold(1 + *std::max_element(fold_of_block.begin(), fold_of_block.end()),
                                 Equations(of.plain()));
  for (std::size_t b = 0; b < of_block.size(); ++b) of_fold[fold_of_block[b]].add(of_block[b], 1.0);
  const Eigen::VectorXd scale = all.gram.diagonal().cwiseSqrt().cwiseInverse();
  const auto trace = [&](const Eigen::MatrixXd& told, const Eigen::MatrixXd& by) {
    const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * by * scale.asDiagonal());
    return solver.solve(scale.asDiagonal() * told * scale.asDiagonal()).trace();
  };
  Eigen::VectorXd out(static_cast<Eigen::Index>(of_fold.size()));
  for (Eigen::Index f = 0; f < out.size(); ++f) {
    const Eigen::MatrixXd& own = of_fold[static_cast<std::size_t>(f)].gram;
    out[f] = variance * (trace(own, all.gram - own) + trace(own, all.gram));
  }
  return out;
}

}  // namespace stillpoint::diag

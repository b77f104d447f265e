#include "diagnosis/reference/blocks_left_out.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

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

/// The columns of one axis, and where their coefficients stand among those of all three.
struct Axis {
  Eigen::MatrixXd design;
  std::vector<Eigen::Index> number;
};

Axis of_axis(const Target& t, const Columns& columns, int axis) {
  Axis out{t.nuisance, std::vector<Eigen::Index>(static_cast<std::size_t>(t.nuisance.cols()))};
  std::iota(out.number.begin(), out.number.end(), axis * t.nuisance.cols());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const auto shown = shown_in(columns[j], axis);
    if (!shown) continue;
    out.design.conservativeResize(Eigen::NoChange, out.design.cols() + 1);
    out.design.rightCols(1) = *shown;
    out.number.push_back(3 * t.nuisance.cols() + static_cast<Eigen::Index>(j));
  }
  return out;
}

/// Adds what an axis says, block by block.
void add_axis(const Target& t, const Axis& axis, int k, const NoiseModel& noise, Eigen::Index block,
              std::vector<Equations>& to) {
  Eigen::MatrixXd white(t.layout.n, axis.design.cols());
  for (Eigen::Index j = 0; j < white.cols(); ++j) white.col(j) = noise.whiten(t.layout, axis.design.col(j), k);
  const Series y = noise.whiten(t.layout, t.residual.col(k), k);
  Eigen::Index begin = 0;
  for (Equations& own : to) {
    const Eigen::Index length = std::min(block, t.layout.n - begin);
    const auto rows = white.middleRows(begin, length);
    own.gram(axis.number, axis.number) += rows.transpose() * rows;
    own.score(axis.number) += rows.transpose() * y.segment(begin, length);
    own.square += y.segment(begin, length).squaredNorm();
    own.counted += t.layout.counts.segment(begin, length).sum();
    begin += length;
  }
}

}  // namespace

LeftOut blocks_left_out(const Target& t, const Columns& columns, const NoiseModel& noise, Eigen::Index block) {
  const Eigen::Index blocks = (t.layout.n + block - 1) / block;
  const Eigen::Index numbers = 3 * t.nuisance.cols() + static_cast<Eigen::Index>(columns.size());
  const std::array<Axis, 3> axes{of_axis(t, columns, 0), of_axis(t, columns, 1), of_axis(t, columns, 2)};
  std::vector<Equations> of_block(static_cast<std::size_t>(blocks), Equations(numbers));
  for (int k = 0; k < 3; ++k) add_axis(t, axes[static_cast<std::size_t>(k)], k, noise, block, of_block);
  Equations all(numbers);
  for (const Equations& own : of_block) all.add(own, 1.0);
  all.gram.diagonal() += (kFree * all.gram.diagonal().array() + 1e-280).matrix();
  const double misfit = all.square - all.score.dot(told_by(all, 1.0).coefficients);
  const double variance = std::max(1.0, misfit / std::max(all.counted, 1.0));
  const double whole = told_by(all, variance).evidence_nats;
  LeftOut out{Eigen::VectorXd(blocks), t.residual};
  for (Eigen::Index b = 0; b < blocks; ++b) {
    Equations others = all;
    others.add(of_block[static_cast<std::size_t>(b)], -1.0);
    const Told by_others = told_by(others, variance);
    out.nats[b] = whole - by_others.evidence_nats;
    const Eigen::Index begin = b * block, length = std::min(block, t.layout.n - begin);
    for (int k = 0; k < 3; ++k) {
      const Axis& axis = axes[static_cast<std::size_t>(k)];
      const Eigen::VectorXd own = by_others.coefficients(axis.number);
      out.residual.col(k).segment(begin, length) -= axis.design.middleRows(begin, length) * own;
    }
  }
  return out;
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/folds.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr double kRegime_s = 1.0;  // a motion, a pose
constexpr int kRegimes = 4, kRounds = 20;
constexpr double kLeastRegime = 0.08;  // of the blocks; fewer are no test

/// A row a block: mean and scatter of the measured vector, what the effects do and how much, each over its spread.
Eigen::MatrixXd looks_of(const Target& t, const Columns& columns, Eigen::Index block) {
  const Eigen::Index blocks = (t.layout.n + block - 1) / block;
  Eigen::MatrixXd driven = Eigen::MatrixXd::Zero(t.layout.n, 1);
  for (const Column& c : columns) driven.col(0) += c.x.rowwise().norm() / std::max(c.x.norm(), 1e-300);
  Eigen::MatrixXd look(blocks, 5);
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index begin = b * block, length = std::min(block, t.layout.n - begin);
    const Eigen::MatrixXd v = t.nuisance.middleRows(begin, length).rightCols(3);
    const Eigen::RowVectorXd mean = v.colwise().mean();
    look.row(b) << mean, (v.rowwise() - mean).norm() / std::sqrt(static_cast<double>(length)),
        driven.middleRows(begin, length).mean();
  }
  for (Eigen::Index c = 0; c < look.cols(); ++c) {
    look.col(c).array() -= look.col(c).mean();
    look.col(c) /= std::max(look.col(c).norm(), 1e-300);
  }
  return look;
}

/// Regimes by k-means from the farthest points; the same input gives the same ones. Empty where one holds nearly all.
std::vector<int> regimes_of(const Eigen::MatrixXd& look) {
  Eigen::MatrixXd centre = look.topRows(1);
  const auto distance = [&](Eigen::Index b) { return (centre.rowwise() - look.row(b)).rowwise().squaredNorm().eval(); };
  while (centre.rows() < kRegimes) {
    Eigen::Index farthest = 0;
    double most = -1.0;
    for (Eigen::Index b = 0; b < look.rows(); ++b)
      if (const double d = distance(b).minCoeff(); d > most) most = d, farthest = b;
    centre.conservativeResize(centre.rows() + 1, Eigen::NoChange);
    centre.bottomRows(1) = look.row(farthest);
  }
  std::vector<int> of_block(static_cast<std::size_t>(look.rows()), 0);
  Eigen::VectorXd size;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kRegimes, look.cols());
    size = Eigen::VectorXd::Zero(kRegimes);
    for (Eigen::Index b = 0; b < look.rows(); ++b) {
      int& regime = of_block[static_cast<std::size_t>(b)];
      distance(b).minCoeff(&regime);
      sum.row(regime) += look.row(b), size[regime] += 1.0;
    }
    for (Eigen::Index k = 0; k < kRegimes; ++k)
      if (size[k] > 0) centre.row(k) = sum.row(k) / size[k];
  }
  if ((size.array() > kLeastRegime * static_cast<double>(look.rows())).count() < 2) return {};
  return of_block;
}

/// A regime of more than half of the blocks in two folds, of pieces beside each other: the rest alone, a few seconds of
/// motion, would have to tell what the whole recording reads at rest.
void split_the_largest(std::vector<int>& of_block) {
  const auto piece = static_cast<std::size_t>(kFold_s / kRegime_s);
  for (int regime = 0; regime < kRegimes; ++regime) {
    if (2 * std::count(of_block.begin(), of_block.end(), regime) <= std::ssize(of_block)) continue;
    for (std::size_t b = 0; b < of_block.size(); ++b)
      if (of_block[b] == regime && (b / piece) % 2 == 1) of_block[b] = kRegimes;
  }
}

}  // namespace

Folds beside_each_other(const Target& t, double block_s, int count) {
  Folds f;
  f.count = count;
  f.block = std::max<Eigen::Index>(1, std::lround(block_s / t.rows.step_s));
  for (Eigen::Index i = 0; i < t.layout.n; ++i) f.of_row.push_back(static_cast<int>((i / f.block) % count));
  return f;
}

Folds by_regime(const Target& t, const Columns& columns) {
  Folds f;
  f.block = std::max<Eigen::Index>(1, std::lround(kRegime_s / t.rows.step_s));
  std::vector<int> of_block = regimes_of(looks_of(t, columns, f.block));
  if (of_block.empty()) return f;
  f.of_regimes = true;
  split_the_largest(of_block);
  f.count = 1 + *std::max_element(of_block.begin(), of_block.end());
  for (Eigen::Index i = 0; i < t.layout.n; ++i) f.of_row.push_back(of_block[static_cast<std::size_t>(i / f.block)]);
  return f;
}

std::vector<int> fold_of_blocks(const Folds& folds) {
  std::vector<int> out;
  for (std::size_t i = 0; i < folds.of_row.size(); i += static_cast<std::size_t>(folds.block))
    out.push_back(folds.of_row[i]);
  return out;
}

}  // namespace stillpoint::diag

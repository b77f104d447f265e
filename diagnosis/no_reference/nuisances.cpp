#include "diagnosis/no_reference/nuisances.h"

namespace stillpoint::diag::detail {
namespace {

/// C^T C, lower half.
Eigen::MatrixXd squared(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  out.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
  return out;
}

void put(Triplets& to, const Eigen::MatrixXd& block, long at_row, long at_col) {
  for (long j = 0; j < block.cols(); ++j)
    for (long i = 0; i < block.rows(); ++i)
      if (at_row + i >= at_col + j)
        to.emplace_back(static_cast<int>(at_row + i), static_cast<int>(at_col + j), block(i, j));
}

}  // namespace

void put_turn(Triplets& to, long row, long apart, long column, const Eigen::Matrix3d& block) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      to.emplace_back(static_cast<int>(row + i * apart), static_cast<int>(column + j), block(i, j));
}

Sparse information(const Sparse& departures, const Eigen::VectorXd& prior_sd, double times) {
  const Eigen::VectorXd weight = times * prior_sd.cwiseAbs2().cwiseInverse();
  Sparse out = Sparse(departures.transpose()) * weight.head(departures.cols()).asDiagonal() * departures;
  out.conservativeResize(prior_sd.size(), prior_sd.size());
  for (long i = departures.cols(); i < prior_sd.size(); ++i) out.coeffRef(i, i) = weight[i];
  return out;
}

Eigen::MatrixXd NuisanceColumns::times(const Eigen::MatrixXd& numbers) const {
  Eigen::MatrixXd out = calibration * numbers.topRows(calibration.cols());
  out += local * numbers.middleRows(calibration.cols(), local.cols());
  out += accepted * numbers.bottomRows(accepted.cols());
  return out;
}

Eigen::MatrixXd NuisanceColumns::transposed_times(const Eigen::MatrixXd& rows) const {
  Eigen::MatrixXd out(size(), rows.cols());
  out.topRows(calibration.cols()) = calibration.transpose() * rows;
  out.middleRows(calibration.cols(), local.cols()) = local.transpose() * rows;
  out.bottomRows(accepted.cols()) = accepted.transpose() * rows;
  return out;
}

Sparse NuisanceColumns::products() const {
  const long c = calibration.cols(), l = local.cols();
  const Sparse locals = local.transpose() * local;
  Triplets entries;
  for (int j = 0; j < locals.outerSize(); ++j)
    for (Sparse::InnerIterator at(locals, j); at; ++at)
      if (at.row() >= j) entries.emplace_back(static_cast<int>(c + at.row()), static_cast<int>(c + j), at.value());
  put(entries, squared(calibration), 0, 0);
  put(entries, local.transpose() * calibration, c, 0);
  put(entries, accepted.transpose() * calibration, c + l, 0);
  put(entries, (local.transpose() * accepted).transpose(), c + l, c);
  put(entries, squared(accepted), c + l, c + l);
  return assembled<Sparse>(size(), size(), entries);
}

NuisanceColumns NuisanceColumns::under(const SparseRows& rows) const {
  return {rows * calibration, rows * local, rows * accepted};
}

Normal::Normal(const NuisanceColumns& n, const Eigen::MatrixXd& k)
    : nuisances(n.products()), across(n.transposed_times(k)), beside(k.transpose() * k) {}

void Normal::add(const Normal& other, double times) {
  nuisances += times * other.nuisances;
  across += times * other.across;
  beside += times * other.beside;
}

void Normal::expect(const Sparse& information, const Eigen::VectorXd& numbers) {
  const Eigen::VectorXd pull = information * numbers;
  const long last = beside.cols() - 1;
  nuisances += information;
  across.col(last) -= pull;
  beside(last, last) += numbers.dot(pull);
}

LeftOver left_over(const Normal& normal) {
  const NuisanceSolver solver(normal.nuisances);
  return {normal.beside - normal.across.transpose() * solver.solve(normal.across),
          solver.vectorD().array().abs().log().sum()};
}

}  // namespace stillpoint::diag::detail

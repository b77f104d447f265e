#include "diagnosis/discovery/term_scan.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/normal_equations.h"

namespace stillpoint::diag {

Columns columns_of_value(const Eigen::MatrixXd& value, bool matrix) {
  if (value.cols() == 1) return on_each_axis(value.col(0));
  return matrix ? matrix_of(value) : diagonal(value);
}

Eigen::MatrixXd TermScan::Base::shares(const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd products(shape.rows(), x.cols());
  products.topRows(dense.cols()) = dense.transpose() * x;
  products.bottomRows(walk.cols()) = walk.products(x);
  return shape.transpose() * products;
}

TermScan::TermScan(const Target& target, const Columns& explained, const NoiseModel& noise)
    : target_(target), noise_(noise) {
  constexpr double kExactCopy = 1e-9;  // of the largest direction's power
  for (int axis = 0; axis < 3; ++axis) {
    Base& base = base_[static_cast<std::size_t>(axis)];
    AxisSystem a = whitened_system({target, target.layout, explained, noise}, axis);
    base.dense = a.design.leftCols(a.plain);
    base.walk = std::move(a.walk);
    const Eigen::VectorXd scale = a.gram.diagonal().cwiseMax(1e-280).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * a.gram * scale.asDiagonal());
    const Eigen::VectorXd& power = eigen.eigenvalues();  // the largest last
    const Eigen::Index rank = (power.array() > kExactCopy * power[power.size() - 1]).count();
    base.shape = scale.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
                 power.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
    const Eigen::VectorXd explains = base.shape * (base.shape.transpose() * a.moment);
    Series& r = residual_[static_cast<std::size_t>(axis)];
    r = a.design.col(a.plain) - base.dense * explains.head(a.plain);
    if (target.walk) r -= base.walk.times(explains.tail(target.walk_terms()));
  }
}

double TermScan::gain(const Columns& columns) const {
  constexpr double kOwn = 1e-4;  // of the power: what has less beside the base is the base
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    Eigen::MatrixXd x(target_.layout.n, static_cast<Eigen::Index>(columns.size()));
    Eigen::Index used = 0;
    for (const Column& c : columns)
      if (const auto shown = shown_in(c, axis)) x.col(used++) = noise_.whiten(target_.layout, *shown, axis);
    x.conservativeResize(Eigen::NoChange, used);
    const Eigen::MatrixXd in_base = base_[a].shares(x);
    Eigen::MatrixXd gram = x.transpose() * x;
    const Eigen::VectorXd whole = gram.diagonal();
    gram -= in_base.transpose() * in_base;
    for (Eigen::Index j = 0; j < used; ++j) gram(j, j) += kOwn * whole[j] + 1e-280;
    const Eigen::VectorXd r = x.transpose() * residual_[a];  // which has no part in the base
    sum += 0.5 * r.dot(gram.llt().solve(r));
  }
  return sum;
}

}  // namespace stillpoint::diag

#include "diagnosis/discovery/term_scan.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "diagnosis/reference/columns.h"

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
    base.dense.resize(target.layout.n, target.nuisance.cols() + static_cast<Eigen::Index>(explained.size()));
    Eigen::Index used = 0;
    const auto add = [&](const Eigen::Ref<const Series>& x) {
      base.dense.col(used++) = noise.whiten(target.layout, x, axis);
    };
    for (Eigen::Index j = 0; j < target.nuisance.cols(); ++j) add(target.nuisance.col(j));
    for (const Column& c : explained)
      if (const auto shown = shown_in(c, axis)) add(*shown);
    base.dense.conservativeResize(Eigen::NoChange, used);
    if (target.walk) base.walk = SlowColumns(target.layout, *target.walk, noise, axis);
    const Eigen::Index K = base.walk.cols();
    Eigen::MatrixXd gram(used + K, used + K);
    gram.topLeftCorner(used, used) = base.dense.transpose() * base.dense;
    gram.bottomLeftCorner(K, used) = base.walk.products(base.dense);
    gram.topRightCorner(used, K) = gram.bottomLeftCorner(K, used).transpose();
    gram.bottomRightCorner(K, K) = base.walk.gram();
    const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-280).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * gram * scale.asDiagonal());
    const Eigen::VectorXd& power = eigen.eigenvalues();  // the largest last
    const Eigen::Index rank = (power.array() > kExactCopy * power[power.size() - 1]).count();
    base.shape = scale.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
                 power.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
    Series& r = residual_[static_cast<std::size_t>(axis)];
    r = noise.whiten(target.layout, target.residual.col(axis), axis);
    const Eigen::VectorXd explains = base.shape * base.shares(r);
    r -= base.dense * explains.head(used);
    if (K > 0) r -= base.walk.times(explains.tail(K));
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

#include "diagnosis/discovery/term_scan.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "diagnosis/reference/columns.h"

namespace stillpoint::diag {

Columns columns_of_value(const Eigen::MatrixXd& value, bool matrix) {
  if (value.cols() == 1) return on_each_axis(value.col(0));
  return matrix ? matrix_of(value) : diagonal(value);
}

TermScan::TermScan(const Target& target, const Columns& explained, const NoiseModel& noise)
    : target_(target), noise_(noise) {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd own(target.layout.n,
                        target.nuisance.cols() + target.walk.cols() + static_cast<Eigen::Index>(explained.size()));
    Eigen::Index used = 0;
    const auto add = [&](const Series& x) {
      const Series white = noise.whiten(target.layout, x, axis);
      if (const double size = white.norm(); size > 1e-280) own.col(used++) = white / size;
    };
    for (Eigen::Index j = 0; j < target.nuisance.cols(); ++j) add(target.nuisance.col(j));
    for (Eigen::Index j = 0; j < target.walk.cols(); ++j) add(target.walk.col(j));
    for (const Column& c : explained)
      if (const auto shown = shown_in(c, axis)) add(*shown);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(own.leftCols(used));
    auto& base = base_[static_cast<std::size_t>(axis)];
    base = qr.householderQ() * Eigen::MatrixXd::Identity(own.rows(), qr.rank());
    Series& r = residual_[static_cast<std::size_t>(axis)];
    r = noise.whiten(target.layout, target.residual.col(axis), axis);
    r -= base * (base.transpose() * r).eval();
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
    const Eigen::MatrixXd in_base = base_[a].transpose() * x;
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

#include "calib_online/offline/alignment.h"

#include <Eigen/Dense>

#include "calib_online/preintegration.h"

namespace stillpoint::calib {
namespace {

using Mat93 = Eigen::Matrix<double, 9, 3>;

Mat9 full(const Array45& lower) {
  Mat9 N;
  std::size_t k = 0;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j <= i; ++j) N(i, j) = N(j, i) = lower[k++];
  return N;
}

/// Row-major, so that (I (x) w^T) rows(O) = O w.
Vec9 rows(const Mat3& O) {
  Vec9 v;
  v << O.row(0).transpose(), O.row(1).transpose(), O.row(2).transpose();
  return v;
}

}  // namespace

void PairwiseSums::add(const Vec3& w_previous, const Vec3& w_this, const Mat3& R, double direction_var,
                       const Mat3& rotation_cov) noexcept {
  Mat39 A = Mat39::Zero();
  for (int i = 0; i < 3; ++i) {
    A.block<1, 3>(i, 3 * i) += w_previous.transpose();
    for (int j = 0; j < 3; ++j) A.block<1, 3>(i, 3 * j) -= R(i, j) * w_this.transpose();
  }
  const Mat3 lever = R * skew(w_this);  // R exp(e) w = R w + R [e] w = R w - R [w] e
  const Mat3 S = 2.0 * direction_var * Mat3::Identity() + lever * rotation_cov * lever.transpose();
  const Mat9 N = A.transpose() * S.inverse() * A;
  std::size_t k = 0;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j <= i; ++j) lower[k++] += N(i, j);
  ++pairs;
}

Alignment align(const PairwiseSums& sums, const Mat3& prior, double sd_limit_rad) noexcept {
  Alignment out;
  if (sums.pairs < 2) {
    out.status = FitStatus::kTooFewPoints;
    return out;
  }
  const Mat9 N = full(sums.lower);
  Mat3 O = prior;
  // Gauss-Newton on O(3) from the prior: quadratic convergence, its misalignment is some degrees at most.
  Mat3 information = Mat3::Zero();
  for (int k = 0; k < 8; ++k) {
    Mat93 D;
    for (int axis = 0; axis < 3; ++axis) D.col(axis) = rows(skew(Vec3::Unit(axis)) * O);
    information = D.transpose() * N * D;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(information);
    if (!(eigen.eigenvalues()[0] * sd_limit_rad * sd_limit_rad > 1.0)) return out;
    const Vec3 delta = -information.ldlt().solve(D.transpose() * (N * rows(O)));
    O = exp_so3(delta) * O;
    if (delta.norm() < 1e-12) break;
  }
  out.R_gyr_triad = O;
  out.covariance = information.inverse();
  out.status = FitStatus::kOk;
  return out;
}

}  // namespace stillpoint::calib

#include "diagnosis/reference/fitted_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/directions.h"

namespace stillpoint::diag {
namespace {

/// Of each axis: its offset, and its row of the matrix below.
Eigen::Map<const Eigen::Matrix<double, 4, 3>> of_axes(const Fit& fit) {
  return Eigen::Map<const Eigen::Matrix<double, 4, 3>>(fit.nuisance.data());
}

}  // namespace

Vec3 fitted_offset(const Fit& fit) { return of_axes(fit).row(0).transpose(); }

Mat3 fitted_matrix(const Fit& fit) { return of_axes(fit).bottomRows<3>().transpose(); }

Mat3 undoing(const Signals& s, Sensor k, const Mat3& D) {
  if (vector_is_reading(s, k)) return Mat3::Identity() - D;
  return (Mat3::Identity() + D).inverse();
}

bool is_no_matrix(const Mat3& map) {
  constexpr double kMostStretch = 2.0;
  return !map.allFinite() || distortion(map) > kMostStretch;
}

Eigen::VectorXd under_prior(const Eigen::VectorXd& fitted, const Eigen::MatrixXd& covariance,
                            const Eigen::VectorXd& prior) {
  const Eigen::MatrixXd both = covariance + Eigen::MatrixXd(prior.asDiagonal());
  return prior.cwiseProduct(both.ldlt().solve(fitted));
}

}  // namespace stillpoint::diag

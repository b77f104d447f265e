/// The bias and matrix that are fitted beside the laws, as what they say of the sensor's own: residual = offset + D v,
/// with v the sensor's `vector`.
#pragma once
#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

[[nodiscard]] Vec3 fitted_offset(const Fit& fit);
[[nodiscard]] Mat3 fitted_matrix(const Fit& fit);  ///< D

/// What brings the readings to the truth: 1 / (1 + D) where v is the truth, 1 - D where it is the reading itself.
[[nodiscard]] Mat3 undoing(const Signals& s, Sensor k, const Mat3& D);

/// More than mounts and wrong matrices stretch a vector: an axis that nothing excites reads only what its prediction
/// has not, and any scale fits.
[[nodiscard]] bool is_no_matrix(const Mat3& map);

/// The likeliest coefficients under a normal prior of these variances about zero.
[[nodiscard]] Eigen::VectorXd under_prior(const Eigen::VectorXd& fitted, const Eigen::MatrixXd& covariance,
                                          const Eigen::VectorXd& prior);

}  // namespace stillpoint::diag

/// A rotation by least squares, with whatever else the residuals depend on beside it, each with its prior. Offline: may
/// allocate.
#pragma once
#include <functional>

#include "core/types.h"

namespace stillpoint::calib {

using VecX = Eigen::VectorXd;
using MatX = Eigen::MatrixXd;

/// Sums over residuals r(phi, x) of three components, R = exp(phi) R_now.
struct NormalEquations {
  MatX N;
  VecX g;
  double chi2 = 0.0;
  int rows = 0;

  explicit NormalEquations(Eigen::Index unknowns) : N(MatX::Zero(unknowns, unknowns)), g(VecX::Zero(unknowns)) {}
  /// `J` has the columns of phi first, then those of x; `rank` of the three components count.
  void add(const MatX& J, const Vec3& r, double variance, int rank = 3);
};

struct RotationFit {
  Mat3 R = Mat3::Identity();
  VecX x;
  MatX covariance;    ///< of phi in the axes that R leads to, then of x
  double chi2 = 0.0;  ///< of rows and priors
  int rows = 0;
  /// chi2 over its mean; 1 when all is as the variances say.
  [[nodiscard]] double excess() const { return chi2 / (rows > 4 ? rows - 3.0 : 1.0); }
  [[nodiscard]] Mat3 rotation_covariance() const { return covariance.topLeftCorner<3, 3>(); }
  [[nodiscard]] double largest_sd_rad() const;
};

using Residuals = std::function<void(const Mat3& R, const VecX& x, NormalEquations& sums)>;

/// Levenberg-Marquardt from `start` and x = 0, the mean of the priors of sd `x_sd`. A direction of the rotation that no
/// residual depends on stays where it was and gets an sd of 1e3 rad.
[[nodiscard]] RotationFit fit_rotation(const Mat3& start, const VecX& x_sd, const Residuals& residuals);

}  // namespace stillpoint::calib

#include "calib_online/quadric.h"

#include <Eigen/Dense>
#include <cmath>

#include "calib_online/directions.h"

namespace stillpoint::calib {

std::optional<Ellipsoid> ellipsoid(const Vec9& p) noexcept {
  if (!p.allFinite()) return std::nullopt;
  Mat3 A;
  A << p[0], p[3] / 2, p[4] / 2, p[3] / 2, p[1], p[5] / 2, p[4] / 2, p[5] / 2, p[2];
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(A);
  const Vec3 lambda = eigen.eigenvalues();
  // A ratio of radii beyond 1e4 is no sensor; it is a degenerate fit that rounding made positive.
  if (!(lambda[0] > 1e-8 * lambda[2])) return std::nullopt;
  const Mat3& V = eigen.eigenvectors();
  const Vec3 centre = -0.5 * (V * lambda.cwiseInverse().asDiagonal() * V.transpose() * p.tail<3>());
  const double sigma = centre.dot(A * centre) + 1.0;
  return Ellipsoid{centre, Mat3(V * (lambda / sigma).cwiseSqrt().asDiagonal() * V.transpose())};
}

double mean_norm_variance(const Mat9& c) noexcept {
  // E[x^4] = 1/5, E[x^2 y^2] = 1/15, E[x^2] = 1/3 on the unit sphere; odd moments vanish.
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += c(i, j) * (i == j ? 1.0 / 5.0 : 1.0 / 15.0);
  for (int i = 3; i < 6; ++i) sum += c(i, i) / 15.0;
  for (int i = 6; i < 9; ++i) sum += c(i, i) / 3.0;
  return 0.25 * sum;
}

WorstDirection worst_norm_variance(const Mat9& covariance) noexcept {
  WorstDirection worst;
  constexpr int kDirections = 48;
  for (int k = 0; k < kDirections; ++k) {
    const Vec3 x = even_direction(k, kDirections);
    const Vec9 d = quadric_terms(x);
    const double variance = 0.25 * d.dot(covariance * d);
    if (variance > worst.variance) worst = {variance, x};
  }
  return worst;
}

}  // namespace stillpoint::calib

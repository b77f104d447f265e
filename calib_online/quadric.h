/// The algebraic ellipsoid d(x)^T p = 1 and the calibration it stands for (docs/math/ellipsoid.md, E1-E5).
/// After Gietzelt et al. eqs. (2), (3) and Zhang eqs. (15)-(21). In working coordinates the prior calibration is the
/// unit sphere, p0 = (1,1,1,0,0,0,0,0,0).
#pragma once
#include <Eigen/Core>
#include <optional>

#include "core/types.h"

namespace stillpoint::calib {

using Vec9 = Eigen::Matrix<double, 9, 1>;
using Mat9 = Eigen::Matrix<double, 9, 9>;

/// d(x) = (x^2, y^2, z^2, xy, xz, yz, x, y, z).
inline Vec9 quadric_terms(const Vec3& x) noexcept {
  Vec9 d;
  d << x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.x() * x.y(), x.x() * x.z(), x.y() * x.z(), x;
  return d;
}

struct Ellipsoid {
  Vec3 centre = Vec3::Zero();
  Mat3 K = Mat3::Identity();  ///< symmetric root: |K (x - centre)| = 1 on the ellipsoid
};

/// E3. Empty when p is not an ellipsoid: the form is not positive definite.
[[nodiscard]] std::optional<Ellipsoid> ellipsoid(const Vec9& p) noexcept;

/// Mean over the unit sphere of the variance of the calibrated norm, E5: trace(Cov(p) E[d d^T]) / 4.
[[nodiscard]] double mean_norm_variance(const Mat9& covariance) noexcept;
/// Its largest value over a net of directions on the sphere, and where it is.
struct WorstDirection {
  double variance = 0.0;
  Vec3 direction = Vec3::UnitZ();
};
[[nodiscard]] WorstDirection worst_norm_variance(const Mat9& covariance) noexcept;

}  // namespace stillpoint::calib

/// The MAP fit to a table of readings: the noise is learnt from what is left over, outliers get Huber's weights.
/// docs/math/ellipsoid.md, (E4). Offline: may allocate.
#pragma once
#include <optional>
#include <span>

#include "calib_online/map_fit.h"

namespace stillpoint::calib {

struct PointsMap {
  FitStatus status = FitStatus::kNotPositiveDefinite;
  Ellipsoid ellipsoid;
  Mat9 covariance = Mat9::Zero();  ///< of the centre, then the upper triangle of the matrix, row by row
  int iterations = 0;
};

/// `x` in working coordinates (the prior is the unit sphere about the origin, `prior_sd` in every number); `noise_sd`
/// of one reading, empty when it is not known.
[[nodiscard]] PointsMap map_points(std::span<const Vec3> x, std::optional<double> noise_sd, double prior_sd);

/// Whether the readings show the sphere about which these working coordinates were made: their directions are wide, or
/// centre and radius are known so much better than `prior_sd` that a prior about them is true.
[[nodiscard]] bool shows_sphere(std::span<const Vec3> x, double prior_sd);

/// The upper triangular matrix U with U^T U = A; pre: A is positive definite.
[[nodiscard]] Mat3 upper_root(const Mat3& A);

}  // namespace stillpoint::calib

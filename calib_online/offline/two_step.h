/// Zhang's transformation matrix from orientations with known rotations between them: his two-step iteration as
/// printed, and the same minimum in closed form from running sums (docs/math/two_step.md, Z1-Z6). After Zhang,
/// "Two-Step Calibration Methods for Miniature Inertial and Magnetic Sensor Units", eqs. (25)-(32).
#pragma once
#include <array>
#include <span>

#include "calib_online/fit_status.h"
#include "calib_online/quadric.h"

namespace stillpoint::calib {

/// sum y y^T, sum y[k] R_j and the count: 37 numbers, whatever the number of orientations. y is the reading minus the
/// bias; R_j takes orientation i to j in body coordinates, u_j = R_j u_i.
struct TwoStepSums {
  Mat3 gram = Mat3::Zero();
  std::array<Mat3, 3> S{Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};
  double count = 0.0;
  void add(const Vec3& y, const Mat3& R_j) noexcept {
    gram += y * y.transpose();
    for (int k = 0; k < 3; ++k) S[static_cast<std::size_t>(k)] += y[k] * R_j;
    count += 1.0;
  }
};

struct TwoStepFit {
  FitStatus status = FitStatus::kNotObservable;
  Mat3 H = Mat3::Zero();
  Vec3 u = Vec3::Zero();     ///< the reference vector, |u| = magnitude
  double contraction = 1.0;  ///< lambda_2 / lambda_1: what one iteration of the paper leaves of the error
};

/// The minimum of (Z 25) under (Z 26): the dominant eigenvector of a 3x3 matrix. Readings alone leave the sign of (H,
/// u) open; it is taken so that H points with `H_prior`.
[[nodiscard]] TwoStepFit two_step_closed(const TwoStepSums& sums, double magnitude, const Mat3& H_prior) noexcept;

/// (Z 30)-(Z 32) as printed, from u_0, `iterations` rounds.
[[nodiscard]] TwoStepFit two_step_iterated(std::span<const Vec3> y, std::span<const Mat3> R, const Vec3& u0,
                                           double magnitude, int iterations);

}  // namespace stillpoint::calib

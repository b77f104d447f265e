/// The gyroscope's matrix H from segments between rest windows: Gauss-Newton with pre-integration in constant memory,
/// and Zhang's unscented Kalman filter for comparison (docs/math/gyro.md, Y1-Y8). After Zhang, eqs. (42)-(45),
/// (52)-(55); with the Hamilton product and body rates his integral is the transpose of R in (Z 24); the sign of each
/// quaternion is free and is aligned here; (Z 53) is 0/0 at rest and is a series here.
#pragma once
#include <span>
#include <vector>

#include "calib_online/fit_status.h"
#include "calib_online/preintegration.h"
#include "calib_online/quadric.h"

namespace stillpoint::calib {

inline constexpr double kGyroNonlinearity = 0.002;     ///< of a turn: what a constant matrix cannot describe
inline constexpr double kGyroWhite_radps_rtHz = 2e-4;  ///< a consumer gyro's 0.01 deg/s/sqrt(Hz)

/// The matrix as nine numbers, row by row.
inline Vec9 rows_of(const Mat3& H) noexcept {
  Vec9 v;
  v << H.row(0).transpose(), H.row(1).transpose(), H.row(2).transpose();
  return v;
}

/// One segment of readings minus bias, equally spaced.
struct GyroSegment {
  std::vector<Vec3> z;
  double dt_s = 0.01;
  Quat reference;  ///< v_start = R(reference) v_end
};

[[nodiscard]] Preintegrated preintegrate(const GyroSegment& segment, const Mat3& H) noexcept;

/// Information about the rows of H: one linear measurement of the rotation, or of what it does to a known direction, a
/// segment. 54 numbers. The measurements are absolute (M h = e + M h_used), so H may be published anew in between.
struct GyroMatrixSums {
  std::array<double, 45> lower{};
  std::array<double, 9> rhs{};
  std::uint32_t segments = 0;

  /// rotation_error = log(R^T R_reference) at H_used, with its covariance.
  void add_rotation(const Vec3& rotation_error, const Mat39& J, const Mat3& H_used, const Mat3& covariance) noexcept;
  /// A world-fixed direction seen before and after: u_start, u_end in body axes, R takes end to start. Blind to the
  /// turn about it.
  void add_direction(const Vec3& u_start, const Vec3& u_end, const Mat3& R, const Mat39& J, const Mat3& H_used,
                     double direction_var, const Mat3& rotation_cov) noexcept;
  /// The length of a turn about one axis: u H Z = angle, with u along H Z (Y9).
  void add_angle(const Vec3& u, const Vec3& Z, double angle, double variance) noexcept;
  void forget(double keep) noexcept;
};

struct GyroMatrixFit {
  FitStatus status = FitStatus::kOk;
  Mat3 H = Mat3::Identity();
  Mat9 covariance = Mat9::Zero();  ///< of the rows of H
};
/// MAP with the prior sd of scale (diagonal) and cross terms about `prior`.
[[nodiscard]] GyroMatrixFit solve(const GyroMatrixSums& sums, const Mat3& prior, double scale_sd,
                                  double cross_sd) noexcept;

/// Gauss-Newton over whole segments against known rotations, from H0. Offline.
[[nodiscard]] Mat3 gyro_matrix_gauss_newton(std::span<const GyroSegment> segments, const Mat3& H0, int iterations);

/// Zhang's UKF, (Z 44)-(Z 45): all segments stacked, repeated `passes` times. `alpha` spreads the sigma points (not
/// stated in the paper). Offline.
[[nodiscard]] Mat3 gyro_matrix_ukf(std::span<const GyroSegment> segments, const Mat3& H0, int passes, double alpha,
                                   double process_var = 1e-1, double measurement_var = 1e-7);

}  // namespace stillpoint::calib

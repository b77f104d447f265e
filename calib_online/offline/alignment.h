/// The rotation between a triad's axes and the gyroscope's, which magnitudes cannot see: from the gyro's rotation
/// between consecutive windows, no common pose needed, so errors of the gyro do not add up (docs/math/alignment.md,
/// L1-L5). Replaces Zhang eqs. (25)-(32) where the rotations come from the device's own gyroscope; the form is ours.
#pragma once
#include "calib_online/fit_status.h"
#include "calib_online/quadric.h"
#include "calib_online/window.h"

namespace stillpoint::calib {

using Array45 = std::array<double, 45>;

/// sum A^T W A with A = I (x) w_previous^T - R (x) w_this^T: 45 numbers.
struct PairwiseSums {
  Array45 lower{};  ///< of the 9x9 matrix, row by row
  std::uint32_t pairs = 0;

  /// Directions in the triad's own calibrated axes (length about `magnitude`), R takes this window's gyro axes to those
  /// of the previous. `direction_var` per axis of one direction; `rotation_cov` rad^2, grows with time and angle.
  void add(const Vec3& w_previous, const Vec3& w_this, const Mat3& R_previous_this, double direction_var,
           const Mat3& rotation_cov) noexcept;
};

struct Alignment {
  FitStatus status = FitStatus::kNotObservable;
  Mat3 R_gyr_triad = Mat3::Identity();  ///< in O(3): a left-handed triad keeps the determinant of its prior
  Mat3 covariance = Mat3::Zero();       ///< rad^2, gyro axes
};
/// `sd_limit_rad`: the largest sd about any axis that still is a result; turns about one axis leave that axis open.
[[nodiscard]] Alignment align(const PairwiseSums& sums, const Mat3& prior, double sd_limit_rad = 0.02) noexcept;

}  // namespace stillpoint::calib

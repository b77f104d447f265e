/// A turn whose angle somebody vouches for: once around by hand between two moments of rest, or a turntable at its
/// rate. About one axis that is fixed in the body, |H Z| is the angle, with Z the integral of the reading less its bias
/// (docs/math/gyro.md, Y9; docs/decisions/178-known-turns.md).
#pragma once
#include <cstdint>
#include <span>

#include "calib_online/gyro_matrix.h"
#include "core/result.h"

namespace stillpoint::calib {

struct StatedTurn {
  double begin_s = 0.0, end_s = 0.0;     ///< since the first row of the recording
  double angle_rad = 0.0, sd_rad = 0.0;  ///< both above zero: the sense of the turn says nothing of the matrix
  bool steady = false;                   ///< at one rate throughout; else from rest to rest
};

struct KnownTurn {
  Vec3 integral_rad = Vec3::Zero();      ///< Z, axes of the raw readings
  Mat3 integral_of_bias = Mat3::Zero();  ///< rad^2, what the bias leaves of Z
  double angle_rad = 0.0;                ///< as stated
  double variance_rad2 = 0.0;            ///< of that, and of all in the reading but bias and matrix
  bool used = false;                     ///< set by the learner: false where it contradicts what is known
};

/// What a matrix makes of a known turn.
struct AngleSeen {
  double angle_rad = 0.0;
  double own_var = 0.0;     ///< rad^2, of angle_rad less the stated angle, were the matrix true
  double matrix_var = 0.0;  ///< rad^2, what the matrix adds to that
  /// By how many of its own deviations it is off.
  [[nodiscard]] double residual_sd(double stated_rad) const noexcept;
  [[nodiscard]] double chi2(double stated_rad) const noexcept;
};
[[nodiscard]] AngleSeen seen_by(const GyroMatrixFit& fit, const KnownTurn& turn) noexcept;
/// (Y9) One linear measurement of the rows of H, about the axis that `fit` sees.
void add_known_turn(const GyroMatrixFit& fit, const KnownTurn& turn, GyroMatrixSums& sums) noexcept;

/// From the rows of a recording, NaN where the gyroscope was not read. Fails with what is wrong and what to do: outside
/// of the recording, a gap, a clipped axis, no rest at an end, no steady rate, hardly a turn, an axis that wanders.
[[nodiscard]] Result<KnownTurn> known_turn(const StatedTurn& stated, std::span<const std::int64_t> t_ns,
                                           std::span<const Vec3> gyr_radps, const Vec3& bias_radps,
                                           const Mat3& bias_covariance);

}  // namespace stillpoint::calib

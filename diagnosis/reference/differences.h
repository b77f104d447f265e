/// Derivatives of sampled motion by differences over 17 rows, of order 16, at the rows' own times, and where a motion
/// is too fast for them.
#pragma once
#include "diagnosis/reference/row_times.h"

namespace stillpoint::diag {

/// Neighbours on either side of a difference: exact to 1e-4 up to a fifth of the sampling rate, where the vibration of
/// rotors and the strike of a heel are. With four, every clean flight had an unexplained line.
inline constexpr Eigen::Index kStencilReach = 8;

/// The samples at the ends, as many as the stencil reaches, take the value next to them.
[[nodiscard]] Series3 derivative(const Series3& x, const RowTimes& rows);
[[nodiscard]] Series3 second_derivative(const Series3& x, const RowTimes& rows);

/// Standard deviation of the derivatives of white noise of the given one, of even rows.
[[nodiscard]] double noise_of_derivative(double sd, double dt_s);
[[nodiscard]] double noise_of_second_derivative(double sd, double dt_s);

/// Of a swing at this frequency: the difference of even rows over the true derivative of this order (1 or 2).
[[nodiscard]] double gain_of_difference(int order, double frequency_hz, double dt_s);

/// What the next shorter stencil gives differently: the size of the error of the derivatives above, up to a factor of
/// ten.
[[nodiscard]] Series derivative_error(const Series3& x, const RowTimes& rows);
[[nodiscard]] Series second_derivative_error(const Series3& x, const RowTimes& rows);

}  // namespace stillpoint::diag

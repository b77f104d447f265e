/// Linear filters applied exactly: in the frequency domain, so that a low-pass far faster than the sampling still has
/// its own delay and its own attenuation, not those of an approximation on the grid.
#pragma once
#include <complex>
#include <functional>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// Complex gain at s = j 2 pi f, f in Hz.
using Response = std::function<std::complex<double>(double frequency_Hz)>;

/// The series, continued at both ends by its mirror image, through the filter; by way of an even grid where its rows
/// are not even.
[[nodiscard]] Series3 apply_response(const Series3& x, const RowTimes& rows, const Response& gain);

/// Zero-phase low-pass with a raised-cosine edge between `pass_Hz` and 1.5 `pass_Hz`.
[[nodiscard]] Response low_pass(double pass_Hz);

/// All within half a band of a frequency, and nothing else.
[[nodiscard]] Response band_pass(double middle_Hz, double half_Hz);

/// Power above a frequency, averaged over about a second, per axis.
[[nodiscard]] Series3 fast_power(const Series3& f, double dt_s, double above_Hz);
/// What the catalogue's <f_hf^2> is: the square of what a first-order high-pass lets through, averaged by a low-pass of
/// the same time constant.
[[nodiscard]] Series3 rectified_power(const Series3& f, double dt_s, double average_s);

/// exp(-s tau)
[[nodiscard]] Response delay_response(double tau_s);
/// 1 / (1 + s tau)
[[nodiscard]] Response first_order_response(double tau_s);
/// w^2 / (s^2 + 2 zeta w s + w^2), w = 2 pi f
[[nodiscard]] Response resonance_response(double frequency_Hz, double damping);

}  // namespace stillpoint::diag

/// Linear filters applied exactly: in the frequency domain, so that a low-pass far faster than the sampling still has
/// its own delay and its own attenuation, not those of an approximation on the grid.
#pragma once
#include <complex>
#include <functional>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// Complex gain at s = j 2 pi f, f in Hz.
using Response = std::function<std::complex<double>(double frequency_Hz)>;

/// The series, continued at both ends by its mirror image, through the filter.
[[nodiscard]] Series3 apply_response(const Series3& x, double dt_s, const Response& gain);

/// Zero-phase low-pass with a raised-cosine edge between `pass_Hz` and 1.5 `pass_Hz`.
[[nodiscard]] Response low_pass(double pass_Hz);

/// Mean square of what is faster than `above_Hz`, over half a second.
[[nodiscard]] Series3 vibration_power(const Series3& f, double dt_s, double above_Hz);

/// exp(-s tau)
[[nodiscard]] Response delay_response(double tau_s);
/// 1 / (1 + s tau)
[[nodiscard]] Response first_order_response(double tau_s);
/// w^2 / (s^2 + 2 zeta w s + w^2), w = 2 pi f
[[nodiscard]] Response resonance_response(double frequency_Hz, double damping);

}  // namespace stillpoint::diag

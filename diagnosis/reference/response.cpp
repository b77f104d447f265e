#include "diagnosis/reference/response.h"

#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "diagnosis/reference/fast_length.h"
#include "simulation/filters.h"

namespace stillpoint::diag {
namespace {

using Complex = std::complex<double>;

Complex laplace(double frequency_Hz) { return {0.0, 2.0 * std::numbers::pi * frequency_Hz}; }

Series3 on_even_rows(const Series3& x, double dt_s, const Response& gain) {
  const Eigen::Index n = x.rows();
  const Eigen::Index half = fast_length_from(n);
  const Eigen::Index length = 2 * half;
  std::vector<Complex> gains(static_cast<std::size_t>(length));
  for (Eigen::Index k = 0; k <= half; ++k) {
    const Complex g = gain(static_cast<double>(k) / (static_cast<double>(length) * dt_s));
    gains[static_cast<std::size_t>(k)] = g;
    gains[static_cast<std::size_t>((length - k) % length)] = std::conj(g);
  }
  gains[static_cast<std::size_t>(half)] = gains[static_cast<std::size_t>(half)].real();
  Eigen::FFT<double> fft;
  Series3 out(n, 3);
  std::vector<Complex> time(static_cast<std::size_t>(length)), spectrum;
  for (int axis = 0; axis < 3; ++axis) {
    for (Eigen::Index i = 0; i < length; ++i) {
      const Eigen::Index mirrored = i < half ? i : length - 1 - i;
      time[static_cast<std::size_t>(i)] = x(std::min(mirrored, n - 1), axis);
    }
    fft.fwd(spectrum, time);
    for (std::size_t k = 0; k < spectrum.size(); ++k) spectrum[k] *= gains[k];
    fft.inv(time, spectrum);
    for (Eigen::Index i = 0; i < n; ++i) out(i, axis) = time[static_cast<std::size_t>(i)].real();
  }
  return out;
}

}  // namespace

Series3 apply_response(const Series3& x, const RowTimes& rows, const Response& gain) {
  if (rows.even()) return on_even_rows(x, rows.step_s, gain);
  const double start_s = rows.at(0), steps = std::ceil((rows.at(x.rows() - 1) - start_s) / rows.step_s);
  const RowTimes even{rows.step_s, {}};
  const Series grid_s = Series::LinSpaced(static_cast<Eigen::Index>(steps) + 1, 0.0, steps * rows.step_s);
  const Series3 through = on_even_rows(at_times(x, rows, grid_s.array() + start_s, kStencilReach), rows.step_s, gain);
  return at_times(through, even, rows.t_s.array() - start_s, kStencilReach);
}

Response low_pass(double pass_Hz) {
  return [pass_Hz](double f) -> Complex {
    if (f <= pass_Hz) return 1.0;
    if (f >= 1.5 * pass_Hz) return 0.0;
    return 0.5 * (1.0 + std::cos(std::numbers::pi * (f - pass_Hz) / (0.5 * pass_Hz)));
  };
}

Response band_pass(double middle_Hz, double half_Hz) {
  return [=](double f) -> Complex { return std::abs(f - middle_Hz) > half_Hz ? 0.0 : 1.0; };
}

Series3 fast_power(const Series3& f, double dt_s, double above_Hz) {
  const Response low = low_pass(above_Hz / 1.5);
  const Series3 fast = on_even_rows(f, dt_s, [&](double x) { return 1.0 - low(x); });
  return on_even_rows(fast.cwiseAbs2(), dt_s, low_pass(1.0)).cwiseMax(0.0);
}

Series3 rectified_power(const Series3& f, double dt_s, double average_s) {
  sim::LowPass<Vec3> mean(average_s), power(average_s);
  Series3 out(f.rows(), 3);
  for (Eigen::Index i = 0; i < f.rows(); ++i) {
    const Vec3 now = f.row(i), fast = now - mean.next(now, dt_s);
    out.row(i) = power.next(fast.cwiseAbs2(), dt_s);
  }
  return out;
}

Response delay_response(double tau_s) {
  return [tau_s](double f) { return std::exp(-laplace(f) * tau_s); };
}

Response first_order_response(double tau_s) {
  return [tau_s](double f) { return 1.0 / (1.0 + laplace(f) * tau_s); };
}

Response resonance_response(double frequency_Hz, double damping) {
  return [frequency_Hz, damping](double f) -> Complex {
    const double x = f / frequency_Hz;
    return 1.0 / Complex(1.0 - x * x, 2.0 * damping * x);
  };
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/band_limit.h"

#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace stillpoint::diag {
namespace {

/// Mean periodogram over windows that lie wholly in one state, their straight line taken out, Hann-weighted.
Series periodogram(const Series3& x, const Mask& rest, bool resting, Eigen::Index length, Eigen::Index& windows) {
  Series sum = Series::Zero(length / 2 + 1);
  Eigen::FFT<double> fft;
  windows = 0;
  for (Eigen::Index begin = 0; begin + length <= x.rows(); begin += length / 2) {
    Eigen::Index quiet = 0;
    for (Eigen::Index i = begin; i < begin + length; ++i) quiet += rest[static_cast<std::size_t>(i)];
    if (resting ? quiet < length : quiet > length / 2) continue;
    ++windows;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> segment(static_cast<std::size_t>(length));
      const double first = x(begin, axis),
                   step = (x(begin + length - 1, axis) - first) / static_cast<double>(length - 1);
      for (Eigen::Index i = 0; i < length; ++i) {
        const double hann =
            0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(length));
        segment[static_cast<std::size_t>(i)] = hann * (x(begin + i, axis) - first - step * static_cast<double>(i));
      }
      std::vector<std::complex<double>> spectrum;
      fft.fwd(spectrum, segment);
      for (Eigen::Index k = 0; k <= length / 2; ++k) sum[k] += std::norm(spectrum[static_cast<std::size_t>(k)]);
    }
  }
  return windows == 0 ? sum : Series(sum / static_cast<double>(windows));
}

/// Without a rest: as high at every frequency as where nothing but noise is left, in the upper half of the band. What
/// still moves there makes it higher, and the band narrower.
Series noise_of_upper_half(const Series& loud) {
  const Eigen::Index half = loud.size() / 2;
  return Series::Constant(loud.size(), quantile(loud.tail(loud.size() - half), 0.5));
}

}  // namespace

double motion_band_hz(const Series3& x, const Mask& rest, double dt_s, double ratio, double lowest_Hz,
                      double highest_Hz) {
  const auto length = static_cast<Eigen::Index>(std::lround(1.28 / dt_s)) / 2 * 2;
  Eigen::Index resting = 0, moving = 0;
  const Series at_rest = periodogram(x, rest, true, length, resting);
  const Series loud = periodogram(x, rest, false, length, moving);
  if (moving < 4) return highest_Hz;
  const Series quiet = resting < 4 ? noise_of_upper_half(loud) : at_rest;
  double band = lowest_Hz;
  for (Eigen::Index k = 1; k + 1 < quiet.size(); ++k) {
    const double frequency = static_cast<double>(k) / (static_cast<double>(length) * dt_s);
    const double noise = quiet.segment(k - 1, 3).sum(), motion = loud.segment(k - 1, 3).sum();
    if (frequency > lowest_Hz && motion < ratio * noise) break;
    band = std::max(band, frequency);
  }
  return std::min(band / 1.25, highest_Hz);  // the low-pass has half its gain at 1.25 times its corner
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/line_evidence.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace stillpoint::diag {
namespace {

using Phasor = Eigen::Vector3cd;

constexpr double kBlock_s = 0.5;
constexpr Eigen::Index kShortest = 8;       // blocks: shorter is an event, no line
constexpr double kNatsForTheStretch = 8.0;  // log of the number of stretches
constexpr double kOffElsewhere = 0.3;       // of the amplitude inside: what a line that is switched off leaves
constexpr double kSensorsOwn = 0.5;         // half way between the reference's (0) and the sensor's (1)
constexpr double kKnown = 0.25;             // two deviations on either side of that
constexpr double kLineOverBeside = 12.0;    // power, of three axes and two phases: chance 1e-13
constexpr int kNearest = 4, kFarthest = 9;  // bins beside the line that tell the reading's background

/// Sums of the line's phasor per block, with how many samples are in them.
struct Demodulated {
  std::vector<Phasor> sum;      // cumulative
  std::vector<double> samples;  // cumulative
  Vec3 noise = Vec3::Zero();    // variance a sample, at this frequency
};

Demodulated demodulate(const Series3& x, const Layout& layout, const Series& t_s, double frequency_Hz,
                       Eigen::Index block) {
  Demodulated d;
  d.sum.emplace_back(Phasor::Zero());
  d.samples.push_back(0.0);
  Phasor last = Phasor::Zero();
  for (Eigen::Index begin = 0; begin < x.rows(); begin += block) {
    Phasor here = Phasor::Zero();
    double n = 0.0;
    for (Eigen::Index i = begin; i < std::min(begin + block, x.rows()); ++i) {
      if (layout.present[i] == 0.0) continue;
      here += x.row(i).transpose() * std::polar(1.0, -2.0 * std::numbers::pi * frequency_Hz * t_s[i]);
      n += 1.0;
    }
    d.sum.push_back(d.sum.back() + here);
    d.samples.push_back(d.samples.back() + n);
    if (begin > 0) d.noise += 0.5 * (here - last).cwiseAbs2();
    last = here;
  }
  d.noise = (d.noise / std::max(d.samples.back(), 1.0)).cwiseMax(1e-300);
  return d;
}

/// Mean squared amplitude of samples [first, last) of blocks, and the log-likelihood that such a line gains.
double gain_of(const Demodulated& d, std::size_t first, std::size_t last) {
  const double n = d.samples[last] - d.samples[first];
  const Phasor sum = d.sum[last] - d.sum[first];
  return n > 0 ? sum.cwiseAbs2().cwiseQuotient(d.noise).sum() / n : 0.0;
}

double amplitude_of(const Demodulated& d, std::size_t first, std::size_t last) {
  const double n = d.samples[last] - d.samples[first];
  return n > 0 ? (d.sum[last] - d.sum[first]).norm() / n : 0.0;
}

/// Amplitude of a line in rows of a window, its ends tapered, muted rows left out.
Phasor tapered(const Series3& x, const Mask& muted, const Window& w, const Series& t_s, double frequency_Hz) {
  Phasor sum = Phasor::Zero();
  double weights = 0.0;
  const auto n = static_cast<double>(w.end - w.begin);
  for (Eigen::Index i = w.begin; i < w.end; ++i) {
    if (muted[static_cast<std::size_t>(i)]) continue;
    const double phase = (static_cast<double>(i - w.begin) + 0.5) / n;
    const double taper = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * phase);
    sum += taper * x.row(i).transpose() * std::polar(1.0, -2.0 * std::numbers::pi * frequency_Hz * t_s[i]);
    weights += taper;
  }
  return sum / std::max(weights, 1e-9);
}

/// Lines of one sensor in a window.
struct Reading {
  const Signals& s;
  Sensor sensor;
  Window w;

  Reading(const Signals& signals, Sensor k, const Window& window)
      : s(signals), sensor(k), w(window.local ? window : Window{false, 0, signals.n}) {}
  [[nodiscard]] Phasor at(const Series3& x, double f) const { return tapered(x, s.muted[sensor], w, s.t_s, f); }
  /// Mean power of the reading at frequencies beside a line.
  [[nodiscard]] double beside(double f) const {
    const double bin_Hz = 1.0 / (static_cast<double>(w.end - w.begin) * s.dt_s);
    double power = 0.0;
    for (int bin = kNearest; bin <= kFarthest; ++bin)
      for (const double sign : {-1.0, 1.0}) power += at(s.reading[sensor], f + sign * bin * bin_Hz).squaredNorm();
    return power / (2.0 * (kFarthest - kNearest + 1));
  }
};

}  // namespace

Window stretch_of_line(const Series3& left, const Layout& layout, const Series& t_s, double frequency_Hz,
                       double step_s) {
  const auto block = std::max<Eigen::Index>(1, std::lround(kBlock_s / step_s));
  const Demodulated d = demodulate(left, layout, t_s, frequency_Hz, block);
  const std::size_t blocks = d.sum.size() - 1;
  const double whole = gain_of(d, 0, blocks);
  std::size_t first = 0, last = blocks;
  double best = whole + kNatsForTheStretch;
  for (std::size_t b = 0; b < blocks; ++b)
    for (std::size_t e = b + kShortest; e <= blocks; ++e)
      if (const double g = gain_of(d, b, e); g > best) best = g, first = b, last = e;
  const double inside = amplitude_of(d, first, last);
  const double outside = std::max(amplitude_of(d, 0, first), amplitude_of(d, last, blocks));
  const bool all_but_ends = static_cast<double>(last - first) > 0.95 * static_cast<double>(blocks);
  if (all_but_ends || outside > kOffElsewhere * inside) return {};
  return {true, static_cast<Eigen::Index>(first) * block,
          std::min(static_cast<Eigen::Index>(last) * block, left.rows())};
}

bool stands_in_reading(const Signals& s, Sensor sensor, const Series3& left, const Window& window,
                       double frequency_Hz) {
  const Reading reading(s, sensor, window);
  const Phasor of_residual = reading.at(left, frequency_Hz), of_reading = reading.at(s.reading[sensor], frequency_Hz);
  const double power = of_residual.squaredNorm(), share = of_residual.dot(of_reading).real() / power;
  return share > kSensorsOwn && std::sqrt(0.5 * reading.beside(frequency_Hz) / power) < kKnown;
}

bool others_swing_too(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz) {
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (k == sensor || !s.present[k]) continue;
    const Reading reading(s, k, window);
    if (reading.at(s.reading[k], frequency_Hz).squaredNorm() > kLineOverBeside * reading.beside(frequency_Hz))
      return true;
  }
  return false;
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/line_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "diagnosis/reference/response.h"

namespace stillpoint::diag {
namespace {

using Phasor = Eigen::Vector3cd;

constexpr double kLineBlock_s = 0.5;
constexpr Eigen::Index kShortest = 8;       // blocks: shorter is an event, no line
constexpr double kNatsForTheStretch = 8.0;  // log of the number of stretches
constexpr double kOffElsewhere = 0.3;       // of the amplitude inside: what a line that is switched off leaves
constexpr double kSensorsOwn = 0.5;         // half way between the reference's (0) and the sensor's (1)
constexpr double kKnown = 0.25;             // two deviations on either side of that
constexpr double kLineOverBeside = 12.0;    // power, of three axes and two phases: chance 1e-13
constexpr double kLongBlock_s = 2.0;        // in which a weak line stands above the noise
constexpr std::size_t kFewestBlocks = 6;
// Of the noise of three axes and two phases on the quieter side, that changes an amplitude: a quarter and more.
constexpr double kAlong = 0.35;
constexpr double kShakes = 20.0;             // times the noise's power
constexpr double kOverNoise = 4.0;           // of variances
constexpr std::array<int, 2> kBeside{3, 4};  // bins of a block: beyond its taper's reach
constexpr double kSwell = 0.15;              // deviation of the amplitude, of itself
constexpr double kIdles = 0.05;              // of the amplitude inside
constexpr int kNearest = 4, kFarthest = 9;   // bins beside the line that tell the reading's background

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

Window rows_of(const Window& window, const Signals& s) { return window.local ? window : Window{false, 0, s.n}; }

/// Lines of rows in a window, those left out that are muted.
struct Lines {
  const Signals& s;
  const Series3& x;
  const Mask& muted;
  Window w;

  [[nodiscard]] Phasor at(double f) const { return tapered(x, muted, w, s.t_s, f); }
  /// Mean power at frequencies beside a line.
  [[nodiscard]] double beside(double f) const {
    const double bin_Hz = 1.0 / (static_cast<double>(w.end - w.begin) * s.dt_s);
    double power = 0.0;
    for (int bin = kNearest; bin <= kFarthest; ++bin)
      for (const double sign : {-1.0, 1.0}) power += at(f + sign * bin * bin_Hz).squaredNorm();
    return power / (2.0 * (kFarthest - kNearest + 1));
  }
};

/// Of what a sensor reads where the reference can be compared.
Lines lines_read(const Signals& s, Sensor k, const Window& window) {
  return {s, s.reading[k], s.muted[k], rows_of(window, s)};
}

/// What the sensor reads that is faster than half of a frequency or so. Where the reference is not to be compared it
/// reads on: rows set aside would tear a line apart.
Series3 without_motion(const Signals& s, Sensor sensor, double frequency_Hz) {
  return apply_response(s.reading[sensor], s.rows,
                        [motion = low_pass(frequency_Hz / 3.0)](double f) { return 1.0 - motion(f); });
}

Mask none_muted(const Signals& s) { return Mask(static_cast<std::size_t>(s.n), 0); }

/// A line in a block of rows, and the mean square of what stands at frequencies beside it.
struct Block {
  double amplitude = 0.0, beside2 = 0.0;
};

std::vector<Block> blocks_of(const Signals& s, const Series3& x, double frequency_Hz, Eigen::Index rows) {
  const Mask none = none_muted(s);
  const double bin_Hz = 1.0 / (static_cast<double>(rows) * s.dt_s);
  std::vector<Block> out;
  for (Eigen::Index begin = 0; begin + rows <= x.rows(); begin += rows) {
    const Lines lines{s, x, none, {true, begin, begin + rows}};
    const auto at = [&lines](double f) { return lines.at(f).norm(); };
    const auto beside2 = [&](double side_Hz) {
      double sum = 0.0;
      for (const int bin : kBeside) sum += std::pow(at(frequency_Hz + bin * side_Hz), 2);
      return sum / std::size(kBeside);
    };
    const double above = beside2(bin_Hz), below = beside2(-bin_Hz);
    // Limbs and vehicles move less the faster; beyond them the louder side holds another rotor.
    out.push_back({at(frequency_Hz), frequency_Hz < kMotionBand_Hz ? 0.5 * (above + below) : std::min(above, below)});
  }
  return out;
}

double mean_of(const std::vector<Block>& blocks, std::size_t first, std::size_t last, const auto& of) {
  double sum = 0.0;
  for (std::size_t b = first; b < last; ++b) sum += of(blocks[b]);
  return sum / static_cast<double>(last - first);
}

/// The amplitudes differ by more than noise, and by much.
bool modulated(const std::vector<Block>& blocks, std::size_t first, std::size_t last) {
  if (last < first + kFewestBlocks) return false;
  const double mean = mean_of(blocks, first, last, [](const Block& b) { return b.amplitude; });
  const double spread2 =
      mean_of(blocks, first, last, [mean](const Block& b) { return std::pow(b.amplitude - mean, 2); });
  const double noise2 = mean_of(blocks, first, last, [](const Block& b) { return kAlong * b.beside2; });
  return spread2 > kOverNoise * noise2 && spread2 - noise2 > kSwell * kSwell * mean * mean;
}

/// Outside of its stretch it is weaker, and still there: an engine that idles.
bool goes_on(const std::vector<Block>& blocks, std::size_t first, std::size_t last) {
  const auto power = [](const Block& b) { return b.amplitude * b.amplitude; };
  const double inside2 = first < last ? mean_of(blocks, first, last, power) : 0.0;
  const auto there = [&](std::size_t from, std::size_t to) {
    if (to < from + kFewestBlocks) return false;
    const double noise2 = mean_of(blocks, from, to, [](const Block& b) { return b.beside2; });
    const double idle2 = mean_of(blocks, from, to, power) - noise2;
    return idle2 > kIdles * kIdles * inside2 && idle2 > kOverNoise * noise2;
  };
  return there(0, first > 0 ? first - 1 : 0) || there(last + 1, blocks.size());
}

}  // namespace

Window stretch_of_line(const Series3& left, const Layout& layout, const Series& t_s, double frequency_Hz,
                       double step_s) {
  const auto block = std::max<Eigen::Index>(1, std::lround(kLineBlock_s / step_s));
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
  const Lines reading = lines_read(s, sensor, window);
  const Phasor of_residual = Lines{s, left, s.muted[sensor], reading.w}.at(frequency_Hz),
               of_reading = reading.at(frequency_Hz);
  const double power = of_residual.squaredNorm(), share = of_residual.dot(of_reading).real() / power;
  return share > kSensorsOwn && std::sqrt(0.5 * reading.beside(frequency_Hz) / power) < kKnown;
}

bool swells(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz) {
  const Window w = rows_of(window, s);
  const Series3 x = without_motion(s, sensor, frequency_Hz);
  for (const double block_s : {kLineBlock_s, kLongBlock_s}) {
    const auto rows = std::max<Eigen::Index>(1, std::lround(block_s / s.dt_s));
    const std::vector<Block> blocks = blocks_of(s, x, frequency_Hz, rows);
    // Where the stretch begins and ends it fills no block.
    const auto first = static_cast<std::size_t>(w.begin / rows) + 1,
               last = std::max(static_cast<std::size_t>(w.end / rows), first + 1) - 1;
    if (modulated(blocks, first, last) || goes_on(blocks, first, last)) return true;
  }
  return false;
}

bool shakes_beside(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz) {
  constexpr double kHann = 1.5;  // of its weights: their squares' sum over that of rows of weight one
  if (frequency_Hz < kMotionBand_Hz) return false;
  const Series3 x = without_motion(s, sensor, frequency_Hz);
  const Mask none = none_muted(s);
  const Lines lines{s, x, none, rows_of(window, s)};
  const auto rows = static_cast<double>(lines.w.end - lines.w.begin);
  const double noise = 3.0 * kHann * s.noise_sd[sensor] * s.noise_sd[sensor] / rows;
  return lines.beside(frequency_Hz) > kShakes * noise;
}

bool others_swing_too(const Signals& s, Sensor sensor, const Window& window, double frequency_Hz) {
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (k == sensor || !s.present[k]) continue;
    const Lines reading = lines_read(s, k, window);
    if (reading.at(frequency_Hz).squaredNorm() > kLineOverBeside * reading.beside(frequency_Hz)) return true;
  }
  return false;
}

}  // namespace stillpoint::diag

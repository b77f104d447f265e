#include "diagnosis/reference/lines.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/fast_length.h"
#include "diagnosis/reference/golden_section.h"
#include "diagnosis/reference/line_evidence.h"

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kBand = 128;      // bins that share one background
constexpr double kLeastOverMean = 35.0;  // sum of three periodograms over their background: chance 2e-13 a bin
constexpr double kSlowestLine_Hz = 0.5;  // slower is motion and drift
constexpr double kOwnPhaseNats = 8.0;    // phases of their own that are worth three numbers more
constexpr int kRefinements = 24;
constexpr double kTaper = 0.1;                      // of a stretch, at either end
constexpr double kOverNear = 0.3 * kLeastOverMean;  // a resonance or the motion itself is broad, a line is not
constexpr Eigen::Index kNear = 12;                  // bins on either side that say so
constexpr double kStands = 12.0;                    // over a mean of 3: chance 2e-3 of three bins
constexpr double kSlowestStep_Hz = 0.4, kFastestStep_Hz = 5.0;
constexpr double kSameLine = 2.0;       // bins
constexpr double kSameVibration = 0.1;  // of its frequency
constexpr double kSpeedsShare = 0.3;    // of its speed, that an engine changes by

/// Rises and falls over the ends: what is slow and strong there would leak over every bin.
Series tapered_ends(Eigen::Index n) {
  const auto last = static_cast<double>(n) - 0.5;
  const Eigen::ArrayXd from_end = Eigen::ArrayXd::LinSpaced(n, 0.5, last).min(Eigen::ArrayXd::LinSpaced(n, last, 0.5));
  return (0.5 - 0.5 * (std::numbers::pi * (from_end / (kTaper * static_cast<double>(n))).min(1.0)).cos()).matrix();
}

/// Power of the three axes at each bin 0..n/2 over the background of its neighbourhood: mean 3 where there is noise.
Series over_background(const Series3& x) {
  const Eigen::Index n = x.rows(), bins = n / 2 + 1;
  Eigen::FFT<double> fft;
  const Series taper = tapered_ends(n);
  Series sum = Series::Zero(bins);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXcd spectrum;
    const Series column = x.col(axis).cwiseProduct(taper);
    fft.fwd(spectrum, column);
    const Series power = spectrum.head(bins).cwiseAbs2();
    for (Eigen::Index first = 0; first < bins; first += kBand) {
      const Eigen::Index last = bins - first < 2 * kBand ? bins : first + kBand;
      std::vector<double> sorted(power.data() + first, power.data() + last);
      std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
      const double mean = sorted[sorted.size() / 2] / std::numbers::ln2;  // median of an exponential
      sum.segment(first, last - first) += power.segment(first, last - first) / std::max(mean, 1e-300);
      if (last == bins) break;
    }
  }
  return sum;
}

/// Amplitudes of sine and cosine at one frequency, per axis (3 x 2).
Eigen::Matrix<double, 3, 2> amplitudes(const Series3& x, const Series& t_s, double frequency_Hz) {
  const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency_Hz * t_s.array();
  Eigen::MatrixXd design(x.rows(), 2);
  design << phase.sin(), phase.cos();
  return 2.0 / static_cast<double>(x.rows()) * x.transpose() * design;
}

Found flip(const Target& t) {
  Found f;
  f.id = "mag_flip";
  f.unit = kSensorUnit[t.sensor];
  f.names = {"b_x", "b_y", "b_z"};
  f.equation = "delta = b (-1)^k";
  f.driver = "sample parity";
  Series parity(t.layout.n);
  for (Eigen::Index i = 0; i < parity.size(); ++i) parity[i] = i % 2 == 0 ? 1.0 : -1.0;
  f.columns = on_each_axis(parity);
  return f;
}

double bin_width_Hz(Eigen::Index rows, double step_s) { return 1.0 / (static_cast<double>(rows) * step_s); }

struct Peak {
  double frequency_Hz = 0.0, over_background = 0.0;
};

/// The strongest bin of these rows that stands alone.
Peak strongest_line(const Series3& left, double step_s, double lowest_Hz) {
  const Series power = over_background(left);
  const double bin_Hz = bin_width_Hz(left.rows(), step_s);
  const auto lowest = static_cast<Eigen::Index>(std::ceil(lowest_Hz / bin_Hz));
  Peak best;
  if (power.size() < lowest + kBand) return best;
  for (Eigen::Index at = lowest; at < power.size(); ++at) {
    if (power[at] < std::max(kLeastOverMean, best.over_background)) continue;
    const Eigen::Index near = std::max<Eigen::Index>(at - kNear, 0), far = std::min(at + kNear, power.size() - 1);
    std::vector<double> around(power.data() + near, power.data() + far + 1);
    std::nth_element(around.begin(), around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2), around.end());
    if (power[at] >= kOverNear * around[around.size() / 2]) best = {static_cast<double>(at) * bin_Hz, power[at]};
  }
  return best;
}

/// An engine's speed is never the same: its line is elsewhere in the next part. A sensor's stays, or is gone.
bool is_of_an_engine(const Peak& peak, const std::vector<Peak>& parts, double bin_Hz) {
  return std::any_of(parts.begin(), parts.end(), [&](const Peak& p) {
    const double off = std::abs(p.frequency_Hz - peak.frequency_Hz);
    return off > kSameLine * bin_Hz && off < kSpeedsShare * peak.frequency_Hz;
  });
}

/// The sharpest line, if there is one: in the whole, or in a half or a quarter of it that it fills better.
std::optional<Peak> sharpest(const Series3& left, const Series& t_s, double step_s, double lowest_Hz) {
  Peak best;
  for (const Eigen::Index parts : {1, 2, 4}) {
    const Eigen::Index rows = fast_length_within(left.rows() / parts), hop = std::max<Eigen::Index>(rows / 2, 1);
    if (parts > 1 && rows < 4 * kBand) break;
    const double bin_Hz = bin_width_Hz(rows, step_s);
    std::vector<Peak> found;
    for (Eigen::Index first = 0; first + rows <= left.rows(); first += hop) {
      const Series3 part = left.middleRows(first, rows);
      Peak peak = strongest_line(part, step_s, lowest_Hz);
      if (peak.over_background == 0.0) continue;
      peak.frequency_Hz = refined_Hz(part, t_s.segment(first, rows), peak.frequency_Hz, bin_Hz, 0.5 / step_s);
      found.push_back(peak);
    }
    for (const Peak& peak : found)
      if (peak.over_background > best.over_background && !is_of_an_engine(peak, found, bin_Hz)) best = peak;
  }
  return best.over_background > 0.0 ? std::optional(best) : std::nullopt;
}

struct Unexplained {
  Target target;  ///< of white noise
  Series3 left;   ///< 0 where a row is absent
};

Unexplained unexplained(const SensorSearch& search) {
  Target plain = search.target;
  plain.layout.order = 0;
  Series3 left = fit_with(plain, search.explained(), NoiseModel(plain.layout, plain.residual), {}).leftover;
  for (int axis = 0; axis < 3; ++axis) left.col(axis).array() *= plain.layout.present;
  return {std::move(plain), std::move(left)};
}

/// Of the frequency, where the line stands so many times above its background.
double deviation_Hz(double over_background, const Window& window, const Target& t) {
  const double lasts_s = window.local ? static_cast<double>(window.end - window.begin) * t.rows.step_s : t.duration_s;
  return std::sqrt(12.0) / (2.0 * std::numbers::pi * lasts_s * std::sqrt(over_background));
}

/// Sine and cosine of each axis.
Columns swings(const SensorSearch& search, const Window& window, double frequency_Hz) {
  const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * frequency_Hz * search.t_s.array();
  Columns out = on_each_axis(angle.sin());
  const Columns cosines = on_each_axis(angle.cos());
  out.insert(out.end(), cosines.begin(), cosines.end());
  return in_window(std::move(out), window);
}

struct Swing {
  double frequency_Hz = 0.0, gain_nats = 0.0;
  Eigen::Matrix<double, 3, 2> amplitude;  ///< of sine and cosine
};

/// A periodogram is blind to the noise's own spectrum: where a reference is quiet, near half its rate, the likelihood
/// knows the frequency a hundred times better.
Swing sharpened(const SensorSearch& search, const Window& window, double frequency_Hz, double deviation_Hz) {
  const Target& t = search.target;
  const Columns explained = search.explained();
  const auto columns = [&](double f) { return joined(explained, swings(search, window, f)); };
  const NoiseModel noise(t.layout, fit_profile(t, columns(frequency_Hz)).leftover);
  const double f =
      highest_by_golden_section(frequency_Hz - 3.0 * deviation_Hz, frequency_Hz + 3.0 * deviation_Hz, kRefinements,
                                [&](double tried) { return fit_with(t, columns(tried), noise, {}).log_likelihood; });
  const Fit fit = fit_with(t, columns(f), noise, {});
  const Eigen::VectorXd six = fit.theta.tail(6);
  return {f, fit.log_likelihood - fit_with(t, explained, noise, {}).log_likelihood,
          Eigen::Map<const Eigen::Matrix<double, 3, 2>>(six.data())};
}

/// One phase for all axes where that explains as much, sine and cosine of each axis else.
Found line(const SensorSearch& search, const Window& window, const Swing& swing) {
  const Sensor k = search.sensor;
  Found f;
  f.id = std::string(kSensorName[k]) + (k == kMag ? "_line" : "_alias");
  f.unit = kSensorUnit[k];
  f.equation = "delta = b sin(2 pi f t + phase)";
  f.driver = "time: a line at one frequency, or folded to it from beyond half the sampling rate";
  f.window = window;
  f.shape = swing.frequency_Hz;
  f.shape_sd = deviation_Hz(std::max(swing.gain_nats, 1.0), window, search.target);
  f.shape_name = "f";
  f.shape_unit = "Hz";
  f.fixed["f_hz"] = swing.frequency_Hz;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(swing.amplitude, Eigen::ComputeThinV);
  const double strong = svd.singularValues()[0], weak = svd.singularValues()[1];
  if (swing.gain_nats * weak * weak / (strong * strong) < kOwnPhaseNats) {
    const double phase = std::atan2(svd.matrixV()(1, 0), svd.matrixV()(0, 0));
    f.fixed["phase_rad"] = phase;
    f.names = {"b_x", "b_y", "b_z"};
    const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * swing.frequency_Hz * search.t_s.array() + phase;
    f.columns = in_window(on_each_axis(angle.sin()), window);
    return f;
  }
  if (k == kGyr) f.id = "gyr_coning";
  f.equation = "delta_i = s_i sin(2 pi f t) + c_i cos(2 pi f t)";
  f.names = {"s_x", "s_y", "s_z", "c_x", "c_y", "c_z"};
  f.columns = swings(search, window, swing.frequency_Hz);
  return f;
}

/// The sharpest line of what is left, from this frequency on.
std::optional<Found> line_left(const Signals& s, const SensorSearch& search, const Unexplained& what,
                               double lowest_Hz) {
  auto [plain, left] = what;
  const auto peak = sharpest(left, search.t_s, plain.rows.step_s, lowest_Hz);
  if (!peak) return std::nullopt;
  const double bin_Hz = bin_width_Hz(left.rows(), plain.rows.step_s), half_rate_Hz = 0.5 / plain.rows.step_s;
  double frequency_Hz = peak->frequency_Hz;
  const Window window = stretch_of_line(left, plain.layout, search.t_s, frequency_Hz, plain.rows.step_s);
  if (window.local) {
    left.topRows(window.begin).setZero(), left.bottomRows(left.rows() - window.end).setZero();
    frequency_Hz = refined_Hz(left, search.t_s, frequency_Hz, bin_Hz, half_rate_Hz);
  }
  if (!s.exact_reference && !stands_in_reading(s, plain.sensor, left, window, frequency_Hz)) return std::nullopt;
  Found f;
  if (is_flip(frequency_Hz, bin_Hz, half_rate_Hz)) {
    if (plain.sensor != kMag) return std::nullopt;
    f = flip(plain);
  } else {
    f = line(search, window,
             sharpened(search, window, frequency_Hz, deviation_Hz(peak->over_background, window, plain)));
  }
  f.kind = Kind::kNamed;
  // What is left of a vibration that swells and turns with the body stands beside it.
  const bool beside = std::any_of(search.found.begin(), search.found.end(), [frequency_Hz](const Found& told) {
    return told.id == kBodyVibration && std::abs(told.shape - frequency_Hz) < kSameVibration * frequency_Hz;
  });
  if (!s.exact_reference && (beside || others_swing_too(s, plain.sensor, window, frequency_Hz))) {
    f.kind = Kind::kConfiguration;
    f.id = kBodyVibration;
  }
  f.units.assign(f.names.size(), f.unit);
  return f;
}

}  // namespace

double refined_Hz(const Series3& x, const Series& t_s, double frequency_Hz, double bin_Hz, double half_rate_Hz) {
  return highest_by_golden_section(frequency_Hz - bin_Hz, std::min(frequency_Hz + bin_Hz, half_rate_Hz), kRefinements,
                                   [&](double f) { return amplitudes(x, t_s, f).squaredNorm(); });
}

std::optional<double> sharpest_line_Hz(const Series3& left, const Series& t_s, double step_s) {
  const auto peak = sharpest(left, t_s, step_s, kSlowestLine_Hz);
  return peak ? std::optional(peak->frequency_Hz) : std::nullopt;
}

bool is_a_harmonic(const Series3& x, double step_s, double frequency_Hz) {
  const Eigen::Index n = fast_length_within(x.rows());
  const Series power = over_background(x.topRows(n));
  const double bin_Hz = bin_width_Hz(n, step_s);
  const Eigen::Index at = std::lround(frequency_Hz / bin_Hz);
  const auto stands = [&power](Eigen::Index bin) {
    return bin > 0 && bin + 1 < power.size() && power.segment(bin - 1, 3).maxCoeff() > kStands;
  };
  for (auto step = std::lround(kSlowestStep_Hz / bin_Hz); step < std::lround(kFastestStep_Hz / bin_Hz); ++step)
    if (stands(at - step) && stands(at - 2 * step) && stands(at - 3 * step)) return true;
  return false;
}

std::optional<double> line_in_world(const Signals& s, const SensorSearch& search) {
  if (s.world_axis[0].rows() != s.n) return std::nullopt;
  const Unexplained body = unexplained(search);
  return sharpest_line_Hz(in_world(s, body.left), search.t_s, body.target.rows.step_s);
}

void sharpen_line(const SensorSearch& without_it, Found& f) {
  const double lasts_s = static_cast<double>(f.window.end - f.window.begin) * without_it.target.rows.step_s;
  const double bin_Hz = 1.0 / (f.window.local ? lasts_s : without_it.target.duration_s);
  Found sharp = line(without_it, f.window, sharpened(without_it, f.window, f.shape, bin_Hz / 6.0));
  if (f.id != kBodyVibration) f.id = std::move(sharp.id), f.equation = std::move(sharp.equation);
  f.shape = sharp.shape, f.shape_sd = sharp.shape_sd, f.fixed = std::move(sharp.fixed);
  f.names = std::move(sharp.names), f.columns = std::move(sharp.columns);
  f.units.assign(f.names.size(), f.unit);
}

std::optional<Found> line_in(const Signals& s, const SensorSearch& search) {
  return line_left(s, search, unexplained(search), kSlowestLine_Hz);
}

std::optional<Found> line_beyond(const Signals& s, const SensorSearch& search, double lowest_Hz) {
  constexpr double kHigher = 1.25;
  const Unexplained what = unexplained(search);
  for (; lowest_Hz < 0.5 / s.dt_s; lowest_Hz *= kHigher)
    if (auto line = line_left(s, search, what, lowest_Hz)) return line;
  return std::nullopt;
}

}  // namespace stillpoint::diag

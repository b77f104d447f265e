#include "diagnosis/reference/peaks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "core/median.h"
#include "diagnosis/reference/fast_length.h"
#include "diagnosis/reference/golden_section.h"

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kBand = 128;      // bins that share one background
constexpr double kLeastOverMean = 35.0;  // sum of three periodograms over their background: chance 2e-13 a bin
constexpr int kPeakRefinements = 24;
constexpr double kStepsABin = 4.0;                  // of the whole: so many find its top
constexpr double kTaper = 0.1;                      // of a stretch, at either end
constexpr double kOverNear = 0.3 * kLeastOverMean;  // a resonance or the motion itself is broad, a line is not
constexpr Eigen::Index kNear = 12;                  // bins on either side that say so
constexpr double kStands = 12.0;                    // over a mean of 3: chance 2e-3 of three bins
constexpr double kOverSkirt = 3.0;
constexpr double kSlowestStep_Hz = 0.4, kFastestStep_Hz = 5.0;
constexpr double kSameLine = 2.0;     // bins
constexpr double kSpeedsShare = 0.3;  // of its speed, that an engine changes by

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
      const double middle = median(std::vector<double>(power.data() + first, power.data() + last));
      const double mean = middle / std::numbers::ln2;  // an exponential's
      sum.segment(first, last - first) += power.segment(first, last - first) / std::max(mean, 1e-300);
      if (last == bins) break;
    }
  }
  return sum;
}

double median_around(const Series& power, Eigen::Index bin) {
  const Eigen::Index near = std::max<Eigen::Index>(bin - kNear, 0), far = std::min(bin + kNear, power.size() - 1);
  return quantile(power.segment(near, far - near + 1), 0.5);
}

/// The strongest bin of these rows that stands alone.
Peak strongest_line(const Series3& left, double step_s, double lowest_Hz) {
  const Series power = over_background(left);
  const double bin_Hz = bin_width_Hz(left.rows(), step_s);
  const auto lowest = static_cast<Eigen::Index>(std::ceil(lowest_Hz / bin_Hz));
  Peak best;
  if (power.size() < lowest + kBand) return best;
  for (Eigen::Index at = lowest; at < power.size(); ++at) {
    if (power[at] < std::max(kLeastOverMean, best.over_background)) continue;
    if (power[at] >= kOverNear * median_around(power, at)) best = {static_cast<double>(at) * bin_Hz, power[at], bin_Hz};
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

}  // namespace

double power_at(const Series3& x, const Series& t_s, double frequency_Hz) {
  const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency_Hz * t_s.array();
  Eigen::Matrix<double, Eigen::Dynamic, 2> design(x.rows(), 2);
  design << phase.sin(), phase.cos();
  const Eigen::Matrix2d gram = design.transpose() * design;
  const Eigen::Matrix<double, 2, 3> with = design.transpose() * x;
  const double ridge = 1e-6 * gram.trace();
  return with.cwiseProduct((gram + ridge * Eigen::Matrix2d::Identity()).ldlt().solve(with)).sum();
}

std::optional<Peak> sharpest_peak(const Series3& left, const Series& t_s, double step_s, double lowest_Hz) {
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

double refined_Hz(const Series3& x, const Series& t_s, double frequency_Hz, double reach_Hz, double half_rate_Hz) {
  const double own_bin_Hz = 1.0 / (t_s[t_s.size() - 1] - t_s[0]), low_Hz = frequency_Hz - reach_Hz;
  const double high_Hz = std::min(frequency_Hz + reach_Hz, half_rate_Hz);
  const int steps = std::max(1, static_cast<int>(std::ceil(kStepsABin * (high_Hz - low_Hz) / own_bin_Hz)));
  const double step_Hz = (high_Hz - low_Hz) / steps;
  const auto power = [&](double f) { return power_at(x, t_s, f); };
  double best_Hz = low_Hz, most = 0.0;
  for (int k = 0; k <= steps; ++k)
    if (const double here = power(low_Hz + k * step_Hz); here > most) most = here, best_Hz = low_Hz + k * step_Hz;
  return highest_by_golden_section(std::max(best_Hz - step_Hz, low_Hz), std::min(best_Hz + step_Hz, high_Hz),
                                   kPeakRefinements, power);
}

bool is_a_harmonic(const Series3& x, double step_s, double frequency_Hz) {
  const Eigen::Index n = fast_length_within(x.rows());
  const Series power = over_background(x.topRows(n));
  const double bin_Hz = bin_width_Hz(n, step_s);
  const Eigen::Index at = std::lround(frequency_Hz / bin_Hz);
  const auto stands = [&power](Eigen::Index bin) {
    if (bin < 1 || bin + 1 >= power.size()) return false;
    const double here = power.segment(bin - 1, 3).maxCoeff();
    return here > kStands && here > kOverSkirt * median_around(power, bin);  // no skirt of a strong line
  };
  for (auto step = std::lround(kSlowestStep_Hz / bin_Hz); step < std::lround(kFastestStep_Hz / bin_Hz); ++step)
    if (stands(at - step) && stands(at - 2 * step) && stands(at - 3 * step)) return true;
  return false;
}

}  // namespace stillpoint::diag

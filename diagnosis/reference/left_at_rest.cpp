#include "diagnosis/reference/left_at_rest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

namespace stillpoint::diag {
namespace {

constexpr double kLeastRest_s = 2.0, kBlock_s = 1.0, kSpectrum_s = 2.0;
constexpr int kLeastBlocks = 12;
constexpr double kWanders = 1.5;      // means of a second over the noise of one row: flicker of parts stays below
constexpr double kTremor_rad = 1e-3;  // of what stands still on a floor that people walk on
constexpr double kLouder = 3.0;       // than configured: a wrong number of the simulation up to there
constexpr double kShare = 0.8, kNarrow = 0.15;  // of the power, within so much of the band
constexpr double kLowest_Hz = 1.0;

struct Rest {
  Eigen::Index begin, end;
};

std::vector<Rest> rests_of(const Signals& s, const Layout& layout) {
  std::vector<Rest> out;
  const auto least = static_cast<Eigen::Index>(kLeastRest_s / s.dt_s);
  const auto still = [&](Eigen::Index i) { return s.rest[static_cast<std::size_t>(i)] && layout.present[i] > 0; };
  each_run(s.n, still, [&](Eigen::Index begin, Eigen::Index end) {
    if (end - begin >= least) out.push_back({begin, end});
  });
  return out;
}

/// Root of the mean square of differences of neighbours: white noise, without what is slower.
double white_sd(const Series& x, const std::vector<Rest>& rests) {
  double sum = 0.0, count = 0.0;
  for (const Rest& r : rests) {
    const Eigen::Index n = r.end - r.begin - 1;
    sum += 0.5 * (x.segment(r.begin + 1, n) - x.segment(r.begin, n)).squaredNorm();
    count += static_cast<double>(n);
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

struct Wander {
  double sd = 0.0;
  int blocks = 0;
};

/// Scatter of means of a second about the mean of their rest.
Wander wander_of(const Series& x, const std::vector<Rest>& rests, Eigen::Index block) {
  double sum = 0.0;
  Wander out;
  int freedom = 0;
  for (const Rest& r : rests) {
    const Eigen::Index blocks = (r.end - r.begin) / block;
    const Series means = x.segment(r.begin, blocks * block).reshaped(block, blocks).colwise().mean().transpose();
    sum += (means.array() - means.mean()).square().sum();
    out.blocks += static_cast<int>(blocks), freedom += static_cast<int>(blocks) - 1;
  }
  out.sd = std::sqrt(sum / std::max(freedom, 1));
  return out;
}

/// Where a narrow band, in each stretch of its own, holds most of the power: the lowest and the highest of them, Hz.
std::optional<std::array<double, 2>> swings_at(const Series3& x, const std::vector<Rest>& rests, double dt_s) {
  const auto n = static_cast<Eigen::Index>(kSpectrum_s / dt_s);
  const double bin_Hz = 1.0 / (static_cast<double>(n) * dt_s);
  const Series hann =
      (2.0 * std::numbers::pi / static_cast<double>(n) * Series::LinSpaced(n, 0.0, static_cast<double>(n - 1)).array())
          .unaryExpr([](double angle) { return 0.5 - 0.5 * std::cos(angle); });
  const auto lowest = static_cast<Eigen::Index>(std::ceil(kLowest_Hz / bin_Hz));
  const auto width = std::max<Eigen::Index>(3, std::lround(kNarrow * static_cast<double>(n / 2 + 1)));
  Eigen::FFT<double> fft;
  double within = 0.0, all = 0.0;
  std::array<double, 2> band{HUGE_VAL, 0.0};
  for (const Rest& r : rests)
    for (Eigen::Index at = r.begin; at + n <= r.end; at += n / 2) {
      Series power = Series::Zero(n / 2 + 1);
      for (int axis = 0; axis < 3; ++axis) {
        const Series part = x.col(axis).segment(at, n);
        const Series windowed = (part.array() - part.mean()) * hann.array();
        Eigen::VectorXcd spectrum;
        fft.fwd(spectrum, windowed);
        power += spectrum.head(power.size()).cwiseAbs2();
      }
      Eigen::Index peak = 0;
      power.tail(power.size() - lowest).maxCoeff(&peak);
      peak += lowest;
      const Eigen::Index first = std::max(lowest, peak - width / 2);
      within += power.segment(first, std::min(width, power.size() - first)).sum(), all += power.sum();
      const double peak_Hz = static_cast<double>(peak) * bin_Hz;
      band = {std::min(band[0], peak_Hz), std::max(band[1], peak_Hz)};
    }
  return within > kShare * all ? std::optional(band) : std::nullopt;
}

Finding nameless(const Signals& s, Sensor k, const Finished& finished, const std::vector<Rest>& rests) {
  Finding out;
  for (std::size_t axis = 0; axis < 3; ++axis)
    out.channels.push_back(std::string(kSensorName[k]) + "_" + kAxisName[axis]);
  out.interval_s = {0.0, s.duration_s()};
  out.held_out.unit = kSensorUnit[k];
  double sum = 0.0, count = 0.0;
  for (const Rest& r : rests) {
    const Series3 x = finished.fit.leftover.middleRows(r.begin, r.end - r.begin);
    sum += (x.rowwise() - x.colwise().mean()).squaredNorm(), count += 3.0 * static_cast<double>(x.rows());
  }
  out.held_out.rms_before = out.held_out.rms_after = std::sqrt(sum / count);
  return out;
}

/// The noise of neighbouring rows and the scatter of means of a second, of one axis.
struct AxisAtRest {
  double noise;
  Wander wander;
};

std::array<AxisAtRest, 3> axes_at_rest(const Signals& s, const SensorSearch& search, const Finished& finished,
                                       const std::vector<Rest>& rests) {
  const auto block = std::max<Eigen::Index>(1, std::lround(kBlock_s / s.dt_s));
  std::array<AxisAtRest, 3> out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Series x = finished.fit.leftover.col(static_cast<Eigen::Index>(axis));
    out[axis] = {std::max(white_sd(x, rests), s.noise_sd[search.sensor]), wander_of(x, rests, block)};
  }
  return out;
}

}  // namespace

std::optional<Finding> wanders_at_rest(const Signals& s, const SensorSearch& search, const Finished& finished) {
  const Sensor k = search.sensor;
  const std::vector<Rest> rests = rests_of(s, search.target.layout);
  if (rests.empty()) return std::nullopt;
  // What a body that only seems to stand still does to gravity, to the field, and in a second to the rate.
  const std::array<double, 3> tremor{kTremor_rad * s.gravity_mps2, kTremor_rad / kBlock_s,
                                     kTremor_rad * s.field_world_uT.norm()};
  const auto axes = axes_at_rest(s, search, finished, rests);
  const auto wanders = [&](const AxisAtRest& a) {
    return a.wander.blocks >= kLeastBlocks && a.wander.sd > std::max(kWanders * a.noise, 3.0 * tremor[k]);
  };
  if (std::none_of(axes.begin(), axes.end(), wanders)) return std::nullopt;
  Finding out = nameless(s, k, finished, rests);
  out.effect = "unknown:u(t)";
  out.equation = "delta = u, of no known form";
  out.driver = "something that no recorded quantity drives: it wanders while the body lies still";
  out.regime = "at rest, where nothing else can";
  out.decided_by = "record every quantity that could drive it: temperature, supply, currents nearby";
  return out;
}

std::optional<std::string> swings_at_rest(const Signals& s, const SensorSearch& search, const Finished& finished) {
  const Sensor k = search.sensor;
  const std::vector<Rest> rests = rests_of(s, search.target.layout);
  const auto axes = axes_at_rest(s, search, finished, rests);
  const double loudest =
      std::max_element(axes.begin(), axes.end(), [](const auto& a, const auto& b) { return a.noise < b.noise; })->noise;
  if (rests.empty() || !(s.noise_sd[k] > 0) || loudest < kLouder * s.noise_sd[k]) return std::nullopt;
  const auto band = swings_at(finished.fit.leftover, rests, s.dt_s);
  if (!band) return std::nullopt;
  return fmt::format("{} at rest swings at {:.3g} to {:.3g} Hz, {:.0f} times its noise, and the reference does not",
                     kSensorName[k], (*band)[0], (*band)[1], loudest / s.noise_sd[k]);
}

}  // namespace stillpoint::diag

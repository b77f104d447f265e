#include "diagnosis/no_reference/lines_at_rest.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <unsupported/Eigen/FFT>

#include "diagnosis/certainty.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/no_reference/search.h"
#include "diagnosis/reference/fast_length.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/peaks.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kSame = 0.02;        // of the frequency: the body swings, and several sensors see it
constexpr double kAlike = 0.4;        // of the amplitude at rest: what motion in the same bin may add
constexpr double kLeastCycles = 2.0;  // in half of the longest rest
constexpr double kNothing = 1e-6;
constexpr double kNatsForNumbers = 2.0 * 6.0;

struct Readings {
  Eigen::ArrayXd t_s;  ///< from the start of the recording
  Series3 corrected;   ///< by the simulation's numbers; gaps hold the reading before
};

Eigen::ArrayXd seconds_of(const io::Recording& r) {
  Eigen::ArrayXd t_s(static_cast<Eigen::Index>(r.size()));
  for (std::size_t i = 0; i < r.size(); ++i) t_s[static_cast<Eigen::Index>(i)] = r.t_s(i) - r.t_s(0);
  return t_s;
}

Readings readings_of(const io::Recording& r, const sim::TriadConfig& simulated, Sensor sensor) {
  const auto& y = triad(r, sensor);
  const auto n = static_cast<Eigen::Index>(y.size());
  Readings out{seconds_of(r), Series3::Zero(n, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    if (y[row].allFinite())
      out.corrected.row(i) = corrected(simulated, y[row]);
    else if (i > 0)
      out.corrected.row(i) = out.corrected.row(i - 1);
  }
  return out;
}

Eigen::MatrixXd sine_and_cosine(const Eigen::ArrayXd& t_s, double frequency_Hz) {
  const Eigen::ArrayXd phase = 2.0 * std::numbers::pi * frequency_Hz * t_s;
  Eigen::MatrixXd out(t_s.size(), 2);
  out << phase.sin(), phase.cos();
  if (out.col(0).cwiseAbs().maxCoeff() < kNothing) out.col(0).setZero();  // at half the rate every sine is rounding
  return out;
}

/// Readings and swing of one half of every rest, each about its mean there.
struct AtRest {
  Eigen::MatrixXd swing;  ///< n x 2
  Series3 readings;       ///< n x 3

  AtRest(const Readings& all, const std::vector<RestWindow>& rest, double frequency_Hz, int half) {
    Eigen::Index n = 0;
    for (const auto& w : rest) n += static_cast<Eigen::Index>(w.last + 1 - w.first) / 2;
    swing.resize(n, 2), readings.resize(n, 3);
    Eigen::Index at = 0;
    for (const auto& w : rest) {
      const auto rows = static_cast<Eigen::Index>(w.last + 1 - w.first) / 2;
      const Eigen::Index first = static_cast<Eigen::Index>(w.first) + half * rows;
      const Eigen::MatrixXd wave = sine_and_cosine(all.t_s.segment(first, rows), frequency_Hz);
      const Series3 y = all.corrected.middleRows(first, rows);
      swing.middleRows(at, rows) = wave.rowwise() - wave.colwise().mean();
      readings.middleRows(at, rows) = y.rowwise() - y.colwise().mean();
      at += rows;
    }
  }
};

using Amplitude = Eigen::Matrix<double, 2, 3>;  ///< of sine and cosine, by axis

/// By how much the amplitude explains the readings of each axis, white noise between.
double gain_nats(const AtRest& rows, const Amplitude& amplitude) {
  double nats = 0.0;
  const Series3 left = rows.readings - rows.swing * amplitude;
  for (int k = 0; k < 3; ++k)
    if (left.col(k).squaredNorm() > 0.0)
      nats += 0.5 * static_cast<double>(left.rows()) *
              std::log(rows.readings.col(k).squaredNorm() / left.col(k).squaredNorm());
  return nats;
}

struct Line {
  double frequency_Hz = 0.0, deviation_Hz = 0.0;
  bool flips = false;  ///< from sample to sample
  Amplitude amplitude = Amplitude::Zero();
  Vec3 deviation = Vec3::Zero(), rms_before = Vec3::Zero(), rms_after = Vec3::Zero();
  double score_nats = 0.0, held_out_nats = 0.0;
  int halves_better = 0;
};

Line line_at(const Readings& readings, const std::vector<RestWindow>& rest, double frequency_Hz) {
  Line line{.frequency_Hz = frequency_Hz};
  std::array<Amplitude, 2> by_half;
  std::vector<AtRest> halves;
  for (int half = 0; half < 2; ++half) {
    halves.emplace_back(readings, rest, frequency_Hz, half);
    by_half[static_cast<std::size_t>(half)] =
        halves.back().swing.completeOrthogonalDecomposition().solve(halves.back().readings);
  }
  line.amplitude = 0.5 * (by_half[0] + by_half[1]);
  Vec3 before = Vec3::Zero(), after = Vec3::Zero();
  double rows = 0.0;
  for (std::size_t half = 0; half < 2; ++half) {
    line.score_nats += gain_nats(halves[half], line.amplitude);
    const double held_out = gain_nats(halves[half], by_half[1 - half]);
    line.held_out_nats += held_out, line.halves_better += held_out > 0.0;
    before += halves[half].readings.colwise().squaredNorm().transpose();
    after += (halves[half].readings - halves[half].swing * line.amplitude).colwise().squaredNorm().transpose();
    rows += static_cast<double>(halves[half].readings.rows());
  }
  line.rms_before = (before / rows).cwiseSqrt(), line.rms_after = (after / rows).cwiseSqrt();
  line.deviation = line.rms_after * std::sqrt(2.0 / rows);
  return line;
}

/// Of the three axes together, at every half bin, relative to the variance of each.
Eigen::ArrayXd power(const Series3& x) {
  Eigen::FFT<double> fft;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(x.rows() + 1);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd padded = Eigen::VectorXd::Zero(2 * x.rows());
    padded.head(x.rows()) = x.col(axis);
    Eigen::VectorXcd spectrum;
    fft.fwd(spectrum, padded);
    sum += spectrum.head(x.rows() + 1).array().abs2() / std::max(x.col(axis).squaredNorm(), 1e-300);
  }
  return sum;
}

/// Nothing but the rests, each about its mean.
Series3 only_rests(const Series3& x, const std::vector<RestWindow>& rest) {
  Series3 out = Series3::Zero(x.rows(), 3);
  for (const auto& w : rest) {
    const auto first = static_cast<Eigen::Index>(w.first), rows = static_cast<Eigen::Index>(w.last + 1 - w.first);
    const Series3 y = x.middleRows(first, rows);
    out.middleRows(first, rows) = y.rowwise() - y.colwise().mean();
  }
  return out;
}

/// The strongest line of the rests, where it goes on through the motion as large as it was. The rests say roughly
/// where it is, the whole recording exactly.
std::optional<Line> strongest(const Readings& readings, const std::vector<RestWindow>& rest, double step_s) {
  const Eigen::Index n = fast_length_within(readings.t_s.size());
  const double span_s = step_s * static_cast<double>(n), half_rate_Hz = 0.5 / step_s, half_bin_Hz = 0.5 / span_s;
  std::size_t longest = 0;
  for (const auto& w : rest) longest = std::max(longest, w.last + 1 - w.first);
  const double longest_s = step_s * static_cast<double>(longest);
  const auto lowest = static_cast<Eigen::Index>(2.0 * kLeastCycles / longest_s / half_bin_Hz);
  if (lowest + 2 >= n) return std::nullopt;
  const Series3 about_mean = readings.corrected.rowwise() - readings.corrected.colwise().mean();
  Eigen::Index at = 0;
  power(only_rests(readings.corrected, rest).topRows(n)).tail(n + 1 - lowest).maxCoeff(&at);
  at += lowest;
  const auto reach = static_cast<Eigen::Index>(0.25 / longest_s / half_bin_Hz) + 1;
  const Eigen::Index from = std::max(at - reach, lowest), to = std::min(at + reach, n);
  Eigen::Index exact = 0;
  power(about_mean.topRows(n)).segment(from, to + 1 - from).maxCoeff(&exact);
  const double near_Hz = half_bin_Hz * static_cast<double>(from + exact);
  const double f = refined_Hz(about_mean, readings.t_s.matrix(), near_Hz, half_bin_Hz, half_rate_Hz);
  const bool flips = is_flip(f, 1.0 / span_s, half_rate_Hz);
  Line line = line_at(readings, rest, flips ? half_rate_Hz : f);
  line.flips = flips;
  const Amplitude throughout =
      sine_and_cosine(readings.t_s, line.frequency_Hz).completeOrthogonalDecomposition().solve(about_mean);
  line.score_nats -= kNatsForNumbers + std::log(static_cast<double>(n));
  if (line.score_nats < kAbstain_nats || line.halves_better < 2 ||
      (throughout - line.amplitude).norm() > kAlike * line.amplitude.norm())
    return std::nullopt;
  line.deviation_Hz = std::sqrt(6.0 / line.score_nats) / (2.0 * std::numbers::pi * span_s);
  return line;
}

/// With one phase for all axes: the strongest direction in the plane of sine and cosine.
Finding describe(const io::Recording& r, const Line& line, Sensor sensor) {
  Finding f;
  f.effect = fmt::format("{}{}", kSensorName[sensor], line.flips ? "_flip" : sensor == kMag ? "_line" : "_alias");
  f.interval_s = {r.t_s(0), r.t_s(r.size() - 1)};
  f.equation = line.flips ? "D = b (-1)^k" : "D = b sin(2 pi f t + phase)";
  f.driver = line.flips ? "sample parity" : "time: a line at one frequency, or folded to it from beyond half the rate";
  f.regime = "seen at rest, where nothing else swings";
  f.decided_by = sensor == kMag
                     ? "another sampling rate: an interference that is folded lies elsewhere then"
                     : "hold the body against something heavy: what shakes it goes, what the sensor makes stays";
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(line.amplitude.transpose(), Eigen::ComputeThinV);
  const Eigen::Vector2d along = line.flips ? Eigen::Vector2d(0.0, 1.0) : Eigen::Vector2d(svd.matrixV().col(0));
  const Vec3 b = line.amplitude.transpose() * along;
  for (int k = 0; k < 3; ++k) {
    const double half = 1.96 * line.deviation[k];
    f.parameters.push_back({fmt::format("b_{}", "xyz"[k]), b[k], {b[k] - half, b[k] + half}, kSensorUnit[sensor]});
    if (std::abs(b[k]) > half) f.channels.push_back(fmt::format("{}_{}", kSensorName[sensor], "xyz"[k]));
  }
  if (!line.flips) {
    const double phase = std::atan2(along[1], along[0]), half_Hz = 1.96 * line.deviation_Hz;
    const double half_rad = 1.96 * line.deviation.minCoeff() / b.norm();
    f.parameters.push_back({"f", line.frequency_Hz, {line.frequency_Hz - half_Hz, line.frequency_Hz + half_Hz}, "Hz"});
    f.parameters.push_back({"phase", phase, {phase - half_rad, phase + half_rad}, "rad"});
  }
  int strong = 0;
  b.cwiseAbs().maxCoeff(&strong);
  f.held_out.rms_before = line.rms_before[strong], f.held_out.rms_after = line.rms_after[strong];
  f.held_out.noise_floor = line.rms_after[strong];
  f.held_out.removable_share_removed = 1.0;
  f.held_out.gain_nats = line.held_out_nats;
  f.held_out.blocks = 2, f.held_out.blocks_better = line.halves_better;
  f.held_out.unit = kSensorUnit[sensor];
  f.p_value = chance_of(line.score_nats);
  f.confidence = confidence_of(line.score_nats);
  return f;
}

void take_out(const Line& line, const sim::TriadConfig& simulated, Sensor sensor, io::Recording& r) {
  auto& y = sensor == kAcc ? r.acc_mps2 : sensor == kGyr ? r.gyr_radps : r.mag_uT;
  const Series3 swing = sine_and_cosine(seconds_of(r), line.frequency_Hz) * line.amplitude;
  const Mat3 raw = simulated.matrix.inverse();
  for (std::size_t i = 0; i < y.size(); ++i) y[i] -= raw * swing.row(static_cast<Eigen::Index>(i)).transpose();
}

bool is_given(const sim::SimulationConfig& simulation, Sensor sensor) {
  return std::any_of(simulation.effects.begin(), simulation.effects.end(), [&](const sim::EffectConfig& e) {
    return e.id.starts_with(kSensorName[sensor]) && (is_line(e.id) || e.id.ends_with("_flip"));
  });
}

}  // namespace

LinesAtRest find_lines_at_rest(const io::Recording& recording, const sim::SimulationConfig& simulation,
                               const std::vector<RestWindow>& rest, const std::vector<std::string>& without) {
  LinesAtRest out{{}, {}, recording};
  if (rest.empty()) return out;
  std::array<std::optional<Line>, 3> lines;
  for (const Sensor s : {kAcc, kGyr, kMag})
    if (const auto* simulated = triad(simulation, s);
        simulated && !triad(recording, s).empty() && !is_given(simulation, s))
      lines[s] = strongest(readings_of(recording, *simulated, s), rest, recording.median_step_s());
  const bool shaken =
      lines[kAcc] && lines[kGyr] &&
      std::abs(lines[kAcc]->frequency_Hz - lines[kGyr]->frequency_Hz) < kSame * lines[kAcc]->frequency_Hz;
  if (shaken)
    out.notices.push_back(
        fmt::format("at rest accelerometer and gyroscope both swing at {:.2f} Hz: something shakes the body",
                    lines[kAcc]->frequency_Hz));
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    if (!lines[s] || (lines[s]->flips && s != kMag)) continue;
    take_out(*lines[s], *triad(simulation, s), s, out.without);
    Finding f = describe(recording, *lines[s], s);
    if (!contains(without, f.effect) && !(shaken && s != kMag)) out.findings.push_back(std::move(f));
  }
  return out;
}

}  // namespace stillpoint::diag::detail

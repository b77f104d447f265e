#include "diagnosis/no_reference/lines_at_rest.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "diagnosis/certainty.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/no_reference/search.h"
#include "diagnosis/reference/lines.h"

namespace stillpoint::diag::detail {
namespace {

constexpr int kMostLines = 5;            // of one sensor; stronger ones may be the motion's
constexpr double kOfHalfTheRate = 0.25;  // of a bin: nearer to it no recording can tell a line from a flip
constexpr double kSame = 0.02;           // of the frequency: the body swings, and several sensors see it
constexpr double kAlike = 0.4;           // of the amplitude at rest: what motion in the same bin may add
constexpr double kLeastCycles = 2.0;     // in half of the longest rest
constexpr double kNothing = 1e-6;
constexpr double kBeside = 4.0;  // bins: what is left of a line that was taken out
constexpr double kNatsForNumbers = 2.0 * 6.0;

struct Readings {
  Eigen::ArrayXd t_s;  ///< from the start of the recording
  Series3 corrected;   ///< by the simulation's numbers; gaps hold the reading before
};

Readings readings_of(const io::Recording& r, const sim::TriadConfig& simulated, Sensor sensor) {
  const auto& y = triad(r, sensor);
  const auto n = static_cast<Eigen::Index>(y.size());
  Readings out{Eigen::ArrayXd(n), Series3::Zero(n, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    out.t_s[i] = r.t_s(row) - r.t_s(0);
    if (y[row].allFinite())
      out.corrected.row(i) = simulated.matrix * (y[row] - simulated.bias);
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

/// The strongest line of the whole recording that stands at rest as well, as large as in motion: the motion's own do
/// not.
std::optional<Line> strongest(Readings readings, const std::vector<RestWindow>& rest, double step_s) {
  const double span_s = step_s * static_cast<double>(readings.t_s.size()), half_rate_Hz = 0.5 / step_s;
  std::size_t longest = 0;
  for (const auto& w : rest) longest = std::max(longest, w.last + 1 - w.first);
  const double lowest_Hz = 2.0 * kLeastCycles / (step_s * static_cast<double>(longest));
  std::vector<double> refused_Hz;
  for (int k = 0; k < kMostLines; ++k) {
    const Series3 about_mean = readings.corrected.rowwise() - readings.corrected.colwise().mean();
    const auto found = sharpest_line_Hz(about_mean, readings.t_s.matrix(), step_s);
    if (!found) return std::nullopt;
    const bool flips = half_rate_Hz - *found < kOfHalfTheRate / span_s;
    Line line = line_at(readings, rest, flips ? half_rate_Hz : *found);
    line.flips = flips;
    line.score_nats -= kNatsForNumbers + std::log(static_cast<double>(readings.t_s.size()));
    const Eigen::MatrixXd wave = sine_and_cosine(readings.t_s, line.frequency_Hz);
    const Amplitude throughout = wave.completeOrthogonalDecomposition().solve(about_mean);
    const bool beside = std::any_of(refused_Hz.begin(), refused_Hz.end(),
                                    [&](double f) { return std::abs(f - line.frequency_Hz) < kBeside / span_s; });
    if (!beside && line.frequency_Hz > lowest_Hz && line.score_nats > kAbstain_nats && line.halves_better == 2 &&
        (throughout - line.amplitude).norm() < kAlike * line.amplitude.norm()) {
      line.deviation_Hz = std::sqrt(6.0 / line.score_nats) / (2.0 * std::numbers::pi * span_s);
      return line;
    }
    readings.corrected -= wave * throughout;
    refused_Hz.push_back(line.frequency_Hz);
  }
  return std::nullopt;
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
  const Mat3 raw = simulated.matrix.inverse();
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Eigen::ArrayXd t_s = Eigen::ArrayXd::Constant(1, r.t_s(i) - r.t_s(0));
    y[i] -= raw * (sine_and_cosine(t_s, line.frequency_Hz) * line.amplitude).transpose();
  }
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
    const bool hidden = std::find(without.begin(), without.end(), f.effect) != without.end();
    if (!hidden && !(shaken && s != kMag)) out.findings.push_back(std::move(f));
  }
  return out;
}

}  // namespace stillpoint::diag::detail

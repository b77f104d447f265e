#include "diagnosis/forensics/forensics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/forensics/examination.h"

namespace stillpoint::diag {
namespace detail {
namespace {

constexpr std::size_t kLatticeBlockRows = 128;
constexpr double kLeastStepOverNoise = 0.1;  // a finer lattice changes nothing that could be seen

double wilson(double k, double n, double z) {
  const double p = k / n, centre = p + z * z / (2 * n);
  return (centre + z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n);
}

}  // namespace

Forensics Examination::run() {
  examine_duplicates();
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    if (axes_[s].empty()) continue;
    examine_hold(s);
    examine_rails(s);
    if (!out_.sensor[s].saturated) examine_peaks(s);
    if (s == kGyr) examine_dead_zone();
    examine_lattice(s);
    if (!out_.sensor[s].held) examine_random_repeats(s);
    examine_bit_flips(s);
    examine_codes(s);
  }
  std::stable_sort(order_.begin(), order_.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (auto& [spoiled, finding] : order_) out_.findings.push_back(std::move(finding));
  return std::move(out_);
}

void Examination::load(Sensor s) {
  const auto& column = triad(recording_, s);
  const auto* config = triad(simulation_, s);
  if (column.empty() || config == nullptr) return;
  axes_[s].resize(3);
  for (int i = 0; i < 3; ++i) {
    Axis& a = axes_[s][static_cast<std::size_t>(i)];
    a.y.reserve(column.size());
    for (const Vec3& v : column) a.y.push_back(v[i]);
    a.printed = printing_step(a.y);
    a.noise_sd = config->noise_sd;
    detail::examine_lattice(a, kLatticeBlockRows);
  }
}

void Examination::examine_duplicates() {
  std::vector<Axis> all;
  int sensors = 0;
  for (const auto& a : axes_) {
    all.insert(all.end(), a.begin(), a.end());
    sensors += !a.empty();
  }
  if (sensors < 2) return;  // one sensor alone cannot tell a lost row from its own stale value
  duplicate_ = find_duplicates(all);
  if (duplicate_.empty()) return;
  std::size_t count = 0, first = duplicate_.size(), last = 0;
  for (std::size_t i = 0; i < duplicate_.size(); ++i) {
    if (!duplicate_[i]) continue;
    ++count, first = std::min(first, i), last = i;
    for (const Sensor s : {kAcc, kGyr, kMag})
      if (!axes_[s].empty()) mute(s, i);
  }
  const auto n = static_cast<double>(recording_.size());
  const auto k = static_cast<double>(count);
  std::vector<std::string> channels;
  for (const Sensor s : {kAcc, kGyr, kMag})
    for (int i = 0; i < 3 && !axes_[s].empty(); ++i) channels.push_back(channel(s, i));
  Finding f = make("sys_dup", std::move(channels), first, last);
  f.equation = "y_k = y_(k-1) in all sensors at random rows";
  f.driver = "lost samples";
  f.regime =
      fmt::format("{} of {} rows equal the row before to the last decimal in every sensor", count, recording_.size());
  f.parameters = {{"rate", k / n, {1.0 - wilson(n - k, n, 1.96), wilson(k, n, 1.96)}, "1"}};
  f.decided_by = "already decided: the values are equal; a sequence counter in the recording would name each loss";
  state(std::move(f), count);
}

void Examination::examine_hold(Sensor s) {
  const auto hold = find_hold(axes_[s], duplicate_);
  if (!hold) return;
  auto& sensor = out_.sensor[s];
  sensor.held = true;
  sensor.hold_period = hold->period_rows;
  std::size_t stale = 0;
  for (std::size_t i = 0; i < hold->stale.size(); ++i)
    if (hold->stale[i]) mute(s, i), ++stale;
  if (s != kMag) {
    out_.notices.push_back(
        fmt::format("{}: values are held for {:.2f} rows on average; the sensor is slower than the file",
                    kSensorName[s], hold->period_rows));
    return;
  }
  Finding f = make("mag_hold", {"mag_x", "mag_y", "mag_z"}, hold->first, hold->last);
  const double span = static_cast<double>(hold->last - hold->first + 1);
  const double resolution = hold->period_rows / span * hold->period_rows;
  const bool whole = std::abs(hold->period_rows - std::round(hold->period_rows)) < 2 * resolution;
  const double n = whole ? std::round(hold->period_rows) : hold->period_rows;
  f.parameters = {{"n", n, {n - (whole ? 0 : resolution), n + (whole ? 0 : resolution)}, "samples"}};
  f.equation = "y_k = y_(n floor(k/n))";
  f.driver = "change of the field between rows";
  f.regime = fmt::format(
      "whenever the body turns; {} of {} rows carry no new value (one fresh value every {:.3g} ms){}", stale,
      recording_.size(), 1e3 * n * recording_.median_step_s(),
      hold->interpolated ? "; every second row is the mean of its neighbours, so the file was resampled" : "");
  f.decided_by = "already decided: exact repeats at a fixed period; a delay or a low-pass leaves none";
  state(std::move(f), stale);
}

void Examination::examine_lattice(Sensor s) {
  std::vector<std::string> channels;
  std::vector<Parameter> steps;
  double weight = 0.0, sum = 0.0, finest = HUGE_VAL, coarsest = 0.0;
  std::size_t first = recording_.size(), last = 0;
  for (int i = 0; i < 3; ++i) {
    const Axis& a = axes_[s][static_cast<std::size_t>(i)];
    const double step = a.lattice.step;
    if (!(step > 0)) continue;
    out_.sensor[s].lattice_step[i] = step;
    if (step < kLeastStepOverNoise * a.noise_sd || (a.lattice.decimal && step < a.noise_sd)) {
      out_.notices.push_back(
          fmt::format("{}: readings lie on steps of {:.4g} {}, far below their noise; nothing to model", channel(s, i),
                      step, kSensorUnit[s]));
      continue;
    }
    const double half = std::max(1.96 * a.lattice.step_sd, 1e-9 * step);
    channels.push_back(channel(s, i));
    steps.push_back({fmt::format("lsb_{}", "xyz"[i]), step, {step - half, step + half}, kSensorUnit[s]});
    const double w = 1.0 / (half * half);
    weight += w, sum += w * step;
    finest = std::min(finest, step), coarsest = std::max(coarsest, step);
    first = std::min(first, a.lattice_first), last = std::max(last, a.lattice_last - 1);
  }
  if (channels.empty()) return;
  out_.sensor[s].quantised = true;
  if (coarsest - finest < 1e-3 * finest) {
    const double lsb = sum / weight, half = 1.0 / std::sqrt(weight);
    steps = {{"lsb", lsb, {lsb - half, lsb + half}, kSensorUnit[s]}};
  }
  Finding f = make(fmt::format("{}_quant", kSensorName[s]), std::move(channels), first, last);
  f.parameters = std::move(steps);
  f.equation = "y = lsb round(y / lsb)";
  f.driver = "none: the lattice of the values";
  const double noise = axes_[s][0].noise_sd;
  f.regime = fmt::format("all readings, rest and motion; adds {:.3g} {} rms of rounding to a noise of {:.3g}",
                         coarsest / std::sqrt(12.0), kSensorUnit[s], noise);
  f.decided_by = "already decided: no reading lies between two steps";
  // Steps below the noise spoil nothing: such a finding stands behind every other.
  state(std::move(f), coarsest > noise ? recording_.size() / 2 : 0);
}

}  // namespace detail

const std::vector<Vec3>& triad(const io::Recording& recording, Sensor sensor) {
  return sensor == kAcc ? recording.acc_mps2 : sensor == kGyr ? recording.gyr_radps : recording.mag_uT;
}

const sim::TriadConfig* triad(const sim::SimulationConfig& simulation, Sensor sensor) {
  const auto& t = sensor == kAcc   ? simulation.accelerometer
                  : sensor == kGyr ? simulation.gyroscope
                                   : simulation.magnetometer;
  return t ? &*t : nullptr;
}

Forensics examine_raw_values(const io::Recording& recording, const sim::SimulationConfig& simulation) {
  if (recording.size() < 2) return {};
  return detail::Examination(recording, simulation).run();
}

}  // namespace stillpoint::diag

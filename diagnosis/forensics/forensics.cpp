#include "diagnosis/forensics/forensics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/detail.h"

namespace stillpoint::diag {
namespace {

using detail::Axis;

constexpr std::size_t kLatticeBlockRows = 128;
constexpr double kLeastStepOverNoise = 0.1;  // a finer lattice changes nothing that could be seen

double wilson(double k, double n, double z) {
  const double p = k / n, centre = p + z * z / (2 * n);
  return (centre + z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n);
}

std::vector<double> scaled(std::vector<double> values, double unit) {
  for (double& v : values) v *= unit;
  return values;
}

class Examination {
 public:
  Examination(const io::Recording& recording, const sim::SimulationConfig& simulation)
      : recording_(recording), simulation_(simulation) {
    for (const Sensor s : {kAcc, kGyr, kMag}) load(s);
  }

  Forensics run() {
    examine_duplicates();
    for (const Sensor s : {kAcc, kGyr, kMag}) {
      if (axes_[s].empty()) continue;
      examine_hold(s);
      examine_rails(s);
      if (!out_.sensor[s].saturated) examine_peaks(s);
      if (s == kGyr) examine_dead_zone();
      examine_lattice(s);
    }
    std::stable_sort(order_.begin(), order_.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (auto& [spoiled, finding] : order_) out_.findings.push_back(std::move(finding));
    return std::move(out_);
  }

 private:
  void load(Sensor s) {
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

  [[nodiscard]] bool simulated(const std::string& id) const {
    return std::any_of(simulation_.effects.begin(), simulation_.effects.end(),
                       [&id](const auto& e) { return e.id == id; });
  }
  [[nodiscard]] std::string channel(Sensor s, int axis) const {
    return fmt::format("{}_{}", kSensorName[s], "xyz"[axis]);
  }
  [[nodiscard]] double t(std::size_t row) const { return recording_.t_s(row); }

  Finding make(const std::string& id, std::vector<std::string> channels, std::size_t first, std::size_t last) const {
    Finding f;
    f.effect = id;
    f.channels = std::move(channels);
    f.interval_s = {t(first), t(last)};
    f.p_value = 1e-12;  // exact values: chance would have to repeat them to the last decimal
    f.confidence = 0.999;
    return f;
  }
  /// A lattice that is there in one part of the recording only; all other faults show where the motion shows them.
  [[nodiscard]] bool lasts_a_while_only(const Finding& f) const {
    const double span_s = t(recording_.size() - 1) - t(0);
    return f.effect.ends_with("_quant") && f.interval_s[1] - f.interval_s[0] < 0.95 * span_s;
  }
  void state(Finding f, std::size_t spoiled_rows) {
    if (simulated(f.effect)) return;
    if (auto e = effect_of(f)) {
      if (lasts_a_while_only(f)) e->window_s = {f.interval_s[0] - t(0), f.interval_s[1] - t(0)};
      out_.effects.push_back(std::move(*e));
    }
    order_.emplace_back(spoiled_rows, std::move(f));
  }
  void mute(Sensor s, std::size_t row) {
    auto& m = out_.sensor[s].muted;
    if (m.empty()) m.assign(recording_.size(), 0);
    m[row] = 1;
  }

  void examine_duplicates() {
    std::vector<Axis> all;
    int sensors = 0;
    for (const auto& a : axes_) {
      all.insert(all.end(), a.begin(), a.end());
      sensors += !a.empty();
    }
    if (sensors < 2) return;  // one sensor alone cannot tell a lost row from its own stale value
    duplicate_ = detail::find_duplicates(all);
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

  void examine_hold(Sensor s) {
    const auto hold = detail::find_hold(axes_[s], duplicate_);
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

  void examine_rails(Sensor s) {
    std::vector<Parameter> levels;
    std::vector<std::string> channels;
    std::size_t spoiled = 0, first = recording_.size(), last = 0;
    double low = HUGE_VAL, high = 0.0, grain = 0.0;
    for (int i = 0; i < 3; ++i) {
      const Axis& a = axes_[s][static_cast<std::size_t>(i)];
      for (const double sign : {1.0, -1.0}) {
        const auto rail = detail::find_rail(a, sign);
        if (!rail) continue;
        for (const std::size_t r : rail->rows) mute(s, r);
        spoiled += rail->rows.size();
        first = std::min(first, rail->rows.front()), last = std::max(last, rail->rows.back());
        low = std::min(low, std::abs(rail->level)), high = std::max(high, std::abs(rail->level));
        grain = std::max(grain, a.grain());
        const double half = 0.5 * a.grain();
        levels.push_back({fmt::format("level_{}{}", "xyz"[i], sign > 0 ? "+" : "-"),
                          rail->level,
                          {rail->level - half, rail->level + half},
                          kSensorUnit[s]});
        if (channels.empty() || channels.back() != channel(s, i)) channels.push_back(channel(s, i));
      }
    }
    if (levels.empty()) return;
    out_.sensor[s].saturated = true;
    if (high - low <= 1.01 * grain)
      levels = {{"level", 0.5 * (low + high), {low - 0.5 * grain, high + 0.5 * grain}, kSensorUnit[s]}};
    Finding f = make(fmt::format("{}_sat", kSensorName[s]), std::move(channels), first, last);
    f.parameters = std::move(levels);
    f.equation = "y = clip(y, +-level)";
    f.driver = "the reading itself";
    f.regime = fmt::format("only at the limit: {} readings lie on it, run into it and leave it steeply", spoiled);
    f.decided_by = "already decided: readings pile up at one value; a larger range setting removes it";
    state(std::move(f), spoiled);
  }

  void examine_peaks(Sensor s) {
    static const std::vector<double> none,
        acc_mps2 = scaled({2, 4, 6, 8, 12, 16, 20, 24, 32, 40, 64, 100, 200, 400}, 9.80665),
        gyr_radps = scaled({125, 250, 450, 500, 1000, 2000, 4000}, M_PI / 180.0);
    const auto peaks = detail::find_clipped_peaks(axes_[s], s == kAcc ? acc_mps2 : s == kGyr ? gyr_radps : none);
    if (!peaks) return;
    std::array<bool, 3> hit{};
    std::size_t first = recording_.size(), last = 0;
    for (const auto& [axis, row] : peaks->rows) {
      mute(s, row);
      hit[static_cast<std::size_t>(axis)] = true;
      first = std::min(first, row), last = std::max(last, row);
    }
    std::vector<std::string> channels;
    for (int i = 0; i < 3; ++i)
      if (hit[static_cast<std::size_t>(i)]) channels.push_back(channel(s, i));
    out_.sensor[s].saturated = true;
    Finding f = make(fmt::format("{}_sat", kSensorName[s]), std::move(channels), first, last);
    f.parameters = {{"level", peaks->level, {peaks->low, peaks->high}, kSensorUnit[s]}};
    f.equation = "y = clip(y, +-level)";
    f.driver = "the reading itself";
    f.regime = fmt::format(
        "shocks only: the {} highest readings, of several axes, agree to {:.2f} % and lie at a customary range, "
        "although "
        "nothing piles up at one number: a calibration after the rail pulls them apart",
        peaks->rows.size(), 100.0 * (peaks->high - peaks->low) / peaks->level);
    f.p_value = 1e-3, f.confidence = 0.95;
    f.decided_by = "the readings before the factory calibration, or a larger range setting";
    state(std::move(f), peaks->rows.size());
  }

  void examine_dead_zone() {
    const auto zone = detail::find_dead_zone(axes_[kGyr]);
    if (!zone) return;
    std::vector<std::string> channels;
    for (int i = 0; i < 3; ++i) {
      const auto& y = axes_[kGyr][static_cast<std::size_t>(i)].y;
      bool any = false;
      for (std::size_t r = zone->first; r <= zone->last; ++r)
        if (y[r] == 0.0) mute(kGyr, r), any = true;
      if (any) channels.push_back(channel(kGyr, i));
    }
    Finding f = make("gyr_deadzone", std::move(channels), zone->first, zone->last);
    f.parameters = {{"d", zone->width, zone->ci95, "rad/s"}};
    f.equation = "y = 0 where |y| < d";
    f.driver = "the reading itself";
    f.regime = fmt::format("slow turns and rest: {} readings are exactly 0 and none lies between 0 and d", zone->zeros);
    f.decided_by = "already decided: exact zeros with an empty gap around them";
    state(std::move(f), zone->zeros);
  }

  void examine_lattice(Sensor s) {
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
            fmt::format("{}: readings lie on steps of {:.4g} {}, far below their noise; nothing to model",
                        channel(s, i), step, kSensorUnit[s]));
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

  const io::Recording& recording_;
  const sim::SimulationConfig& simulation_;
  std::array<std::vector<Axis>, 3> axes_;
  std::vector<std::uint8_t> duplicate_;
  std::vector<std::pair<std::size_t, Finding>> order_;
  Forensics out_;
};

}  // namespace

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
  return Examination(recording, simulation).run();
}

}  // namespace stillpoint::diag

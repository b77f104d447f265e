#include "diagnosis/sanity/sanity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr std::size_t kLeastRows = 200;
constexpr double kLeastDuration_s = 5.0;
constexpr std::size_t kManyRows = 5000;  // thinned files may carry a false clock: enough rows are worth a look

bool turns(const io::Recording& r, const sim::SimulationConfig& config) {
  if (triad(config, kGyr) == nullptr) return true;  // nothing that could say otherwise
  std::size_t moving = 0, measured = 0;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& y : r.gyr_radps)
    if (y.allFinite()) mean += y, ++measured;
  if (measured == 0) return true;
  mean /= static_cast<double>(measured);
  for (const Vec3& y : r.gyr_radps) moving += y.allFinite() && (y - mean).norm() > 0.2;
  return static_cast<double>(moving) > 0.01 * static_cast<double>(r.size());
}

bool all_unusable(const Sanity& s) { return s.unusable[kAcc] && s.unusable[kGyr] && s.unusable[kMag]; }

/// Where the reader dropped most of the rows, what is left is not the recording.
void check_what_was_dropped(const io::Recording& r, Sanity& out) {
  constexpr double kMost = 0.6;
  const auto& issues = r.issues;
  const double dropped = static_cast<double>(issues.dropped_rows()), all = dropped + static_cast<double>(r.size());
  if (dropped < kMost * all) return;
  const auto tell = [&](const io::Irregularity& what, const char* words) {
    out.mistake(
        fmt::format("time: {} rows were dropped, the first in line {}: {}", what.count, what.first_line, words));
  };
  const std::size_t worst = std::max({issues.repeated_time.count, issues.backward_time.count, issues.malformed.count});
  if (worst == issues.repeated_time.count)
    tell(issues.repeated_time,
         "their time repeats the row before; the time column does not count, or has too few digits");
  else if (worst == issues.backward_time.count)
    tell(issues.backward_time,
         "their time lies before that of an earlier row; one wrong time stamp, rows out of order, or a counter that "
         "started anew");
  else
    tell(issues.malformed, "they cannot be read; `stillpoint check` names them");
}

}  // namespace

namespace detail {

void check_columns(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  const std::array<bool, 3> counts{r.acc_in_counts, r.gyr_in_counts, r.mag_in_counts};
  for (const Sensor s : {kAcc, kGyr, kMag}) {
    const auto& column = triad(r, s);
    if (triad(config, s) == nullptr || column.empty()) {
      out.unusable[s] = true;
      if (triad(config, s) != nullptr)
        out.notices.push_back(
            fmt::format("{}: the simulation has it, the recording has no such columns", kSensorName[s]));
      continue;
    }
    if (counts[s]) {
      out.set_aside(s,
                    fmt::format("{}: readings are in counts; without the scale of the sensor they cannot be compared",
                                kSensorName[s]));
      continue;
    }
    std::array<std::size_t, 3> per_axis{};
    std::size_t measured = 0;
    Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL);
    for (const Vec3& y : column) {
      for (int k = 0; k < 3; ++k) per_axis[static_cast<std::size_t>(k)] += std::isfinite(y[k]);
      if (y.allFinite()) low = low.cwiseMin(y), high = high.cwiseMax(y), ++measured;
    }
    if (measured < kLeastRows / 2) {
      std::string empty;
      for (std::size_t k = 0; k < 3; ++k)
        if (per_axis[k] == 0) empty += fmt::format("{}{}_{}", empty.empty() ? "" : ", ", kSensorName[s], "xyz"[k]);
      out.set_aside(
          s, empty.empty()
                 ? fmt::format("{}: only {} readings of all three axes", kSensorName[s], measured)
                 : fmt::format("{}: no reading in any row that can be compared: empty or NaN in all of them", empty));
      continue;
    }
    for (int k = 0; k < 3; ++k)
      if (!(high[k] > low[k]))
        out.set_aside(s, fmt::format("{}_{}: every reading is {:.6g}: the axis is stuck or the column was filled in",
                                     kSensorName[s], "xyz"[k], low[k]));
  }
}

void check_clock(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  constexpr double kNear = 1.3;
  const double rate_hz = 1.0 / std::max(r.median_step_s(), 1e-9), ratio = rate_hz / config.rate_hz;
  for (const double unit : {1e3, 1e6, 1e9}) {
    const bool finer = ratio * unit < kNear && ratio * unit > 1 / kNear;
    const bool coarser = ratio / unit < kNear && ratio / unit > 1 / kNear;
    if (!finer && !coarser) continue;
    out.mistake(
        fmt::format("time: {:.4g} rows a second where the simulation says rate_hz: {:.4g}: the time column counts "
                    "in a unit {:.0e} times {} than its name says; name it time_s, time_ms, time_us or time_ns "
                    "after its unit",
                    rate_hz, config.rate_hz, unit, finer ? "finer" : "coarser"));
    out.nothing_usable = true;
    return;
  }
  if (ratio > 1.1 || ratio < 1 / 1.1)
    out.notices.push_back(
        fmt::format("time: {:.4g} rows a second, the simulation says rate_hz: {:.4g}; the recording's own times "
                    "are used",
                    rate_hz, config.rate_hz));
}

}  // namespace detail

Sanity check_input(const io::Recording& r, const sim::SimulationConfig& config) {
  Sanity out;
  check_what_was_dropped(r, out);
  if (r.size() > 20) detail::check_clock(r, config, out);
  if (out.nothing_usable) return out;
  const double duration_s = r.size() > 1 ? r.t_s(r.size() - 1) - r.t_s(0) : 0.0;
  if (r.size() < kLeastRows || (duration_s < kLeastDuration_s && r.size() < kManyRows)) {
    out.mistake(
        fmt::format("too short: {} rows over {:.2f} s; record at least 30 s, better two minutes, with rests of "
                    "3 s between turns about all axes",
                    r.size(), duration_s));
    out.nothing_usable = true;
    return out;
  }
  detail::check_columns(r, config, out);
  detail::check_units(r, config, out);
  if (!r.ref_q_world_body.empty() && !out.nothing_usable) detail::check_reference(r, config, out);
  if (!turns(r, config))
    out.notices.push_back(
        "no motion: only what shows at rest can be seen (temperature, supply, current, drift, lattice, noise); "
        "everything that needs rotation or acceleration stays untested");
  out.nothing_usable = out.nothing_usable || all_unusable(out);
  return out;
}

}  // namespace stillpoint::diag

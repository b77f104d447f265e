// When the sensors of a recording were read: each has its own rate and its own gaps.
#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "core/units.h"
#include "io/recording.h"

namespace stillpoint::io {
namespace {

constexpr double kGapOverMedianStep = 2.5;

/// Pre: at least two times.
double median_step_s(const std::vector<std::int64_t>& t_ns) {
  std::vector<std::int64_t> steps(t_ns.size() - 1);
  for (std::size_t i = 1; i < t_ns.size(); ++i) steps[i - 1] = t_ns[i] - t_ns[i - 1];
  return in_seconds(median(std::move(steps)));
}

/// Rows in which the sensor was read.
std::vector<std::size_t> rows_of(const Recording& r, SamplePart part) {
  std::vector<std::size_t> rows;
  const auto take = [&](const auto& column, const auto& is_there) {
    for (std::size_t row = 0; row < column.size(); ++row)
      if (is_there(column[row])) rows.push_back(row);
  };
  const auto triad = [](const Vec3& v) { return v.allFinite(); };
  if (part == kAcc) take(r.acc_mps2, triad);
  if (part == kGyr) take(r.gyr_radps, triad);
  if (part == kMag) take(r.mag_uT, triad);
  if (part == kTemp) take(r.temp_degC, [](double x) { return std::isfinite(x); });
  return rows;
}

/// `on_gap(row, seconds)` is told of the row that ends each gap.
template <class OnGap>
SensorTimes times_of(const Recording& r, SamplePart part, const char* name, const OnGap& on_gap) {
  const auto rows = rows_of(r, part);
  SensorTimes out{name, rows.size()};
  if (rows.size() < 2) return out;
  std::vector<std::int64_t> t_ns(rows.size());
  std::transform(rows.begin(), rows.end(), t_ns.begin(), [&r](std::size_t row) { return r.t_ns[row]; });
  out.median_step_s = median_step_s(t_ns);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double dt_s = in_seconds(t_ns[i] - t_ns[i - 1]);
    if (dt_s <= kGapOverMedianStep * out.median_step_s) continue;
    ++out.gaps;
    out.longest_gap_s = std::max(out.longest_gap_s, dt_s);
    on_gap(rows[i], dt_s);
  }
  return out;
}

constexpr std::pair<SamplePart, const char*> kParts[] = {{kAcc, "acc"}, {kGyr, "gyr"}, {kMag, "mag"}, {kTemp, "temp"}};

}  // namespace

double Recording::median_step_s() const { return size() < 2 ? 0.0 : io::median_step_s(t_ns); }

std::vector<SensorTimes> sensor_times(const Recording& recording) {
  std::vector<SensorTimes> out;
  for (const auto& [part, name] : kParts)
    if (const auto times = times_of(recording, part, name, [](std::size_t, double) {}); times.readings > 0)
      out.push_back(times);
  return out;
}

void find_gaps(Recording& recording, const std::vector<std::size_t>& lines) {
  std::vector<std::size_t> ends;  // lines; a row that ends the gap of three sensors at once is one
  for (const auto& [part, name] : kParts) {
    if (part == kTemp) continue;  // between two readings of a thermometer the last one holds
    times_of(recording, part, name, [&](std::size_t row, double dt_s) {
      ends.push_back(lines[row]);
      recording.issues.longest_gap_s = std::max(recording.issues.longest_gap_s, dt_s);
    });
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  for (const std::size_t line : ends) recording.issues.gap.note(line);
}

}  // namespace stillpoint::io

#include "diagnosis/sanity/sanity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr std::size_t kLeastRows = 200;
constexpr double kLeastDuration_s = 5.0;
constexpr std::size_t kManyRows = 5000;  // thinned files may carry a false clock: enough rows are worth a look
constexpr double kGravity_mps2 = 9.80665;

double median(std::vector<double> v) {
  if (v.empty()) return 0.0;
  const auto middle = v.begin() + static_cast<long>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// Of the raw readings: the offset of the simulation, in the right unit, would hide readings in a wrong one.
double median_norm(const std::vector<Vec3>& readings) {
  std::vector<double> norms;
  for (const Vec3& y : readings)
    if (y.allFinite()) norms.push_back(y.norm());
  return median(std::move(norms));
}

struct UnitMistake {
  double factor;  ///< readings are this many times too large
  const char* unit;
};

/// Names the unit whose factor brings `norm` near `expected`; a norm within a factor of 2.2 is believed.
void check_norm(Sensor s, double norm, double expected, std::initializer_list<UnitMistake> mistakes, Sanity& out) {
  if (!(expected > 0) || (norm < 2.2 * expected && norm > expected / 2.2)) return;
  for (const auto& m : mistakes) {
    const double ratio = norm / (m.factor * expected);
    if (ratio > 1.6 || ratio < 1 / 1.6) continue;
    out.notices.push_back(
        fmt::format("{}: the norm of the readings is {:.4g} where {:.4g} {} is expected: they look like {}; "
                    "name the column after its unit or convert it",
                    kSensorName[s], norm, expected, kSensorUnit[s], m.unit));
    out.unusable[s] = true;
    return;
  }
  if (s == kAcc) return;  // free fall and launches have any norm
  out.notices.push_back(
      fmt::format("{}: the norm of the readings is {:.4g} where the simulation has {:.4g} {}: "
                  "wrong field_world_uT, wrong unit or a magnet close by",
                  kSensorName[s], norm, expected, kSensorUnit[s]));
}

/// Regresses the change of the measured field on -omega x m over pieces of about 0.1 s: the slope is 1 where the gyro
/// is in rad/s, and 0.017 where it is in degrees per second.
void check_rate_unit(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  const auto* gyro = triad(config, kGyr);
  const Sensor other = triad(config, kMag) && !r.mag_uT.empty() ? kMag : kAcc;
  const auto* field = triad(config, other);
  const auto& v = triad(r, other);
  if (!gyro || !field || r.gyr_radps.empty() || v.empty() || out.unusable[other]) return;
  const double step_s = r.median_step_s();
  const auto piece = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.1 / std::max(step_s, 1e-6))));
  Vec3 before = Vec3::Constant(io::kMissing);
  double pp = 0, pd = 0, dd = 0;
  for (std::size_t i = 0; i + piece <= r.size(); i += piece) {
    Vec3 w = Vec3::Zero(), m = Vec3::Zero();
    for (std::size_t j = i; j < i + piece; ++j) {
      w += gyro->matrix * (r.gyr_radps[j] - gyro->bias) / static_cast<double>(piece);
      m += field->matrix * (v[j] - field->bias) / static_cast<double>(piece);
    }
    if (before.allFinite() && m.allFinite() && w.allFinite()) {
      const Vec3 predicted = -w.cross(0.5 * (m + before)) * step_s * static_cast<double>(piece);
      const Vec3 change = m - before;
      pp += predicted.squaredNorm(), pd += predicted.dot(change), dd += change.squaredNorm();
    }
    before = m;
  }
  if (!(pp > 0) || !(dd > 0)) return;
  const double slope = pd / pp, correlation = pd / std::sqrt(pp * dd);
  if (correlation > 0.4 && slope > 1.0 / 90 && slope < 1.0 / 35) {
    out.notices.push_back(
        "gyr: turns the measured field 57 times too fast: the readings look like degrees per second; "
        "name the columns gyr_x_dps ... or convert them");
    out.unusable[kGyr] = true;
  }
}

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
      out.unusable[s] = true;
      out.notices.push_back(fmt::format(
          "{}: readings are in counts; without the scale of the sensor they cannot be compared", kSensorName[s]));
      continue;
    }
    Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL);
    std::size_t measured = 0;
    for (const Vec3& y : column)
      if (y.allFinite()) low = low.cwiseMin(y), high = high.cwiseMax(y), ++measured;
    if (measured < kLeastRows / 2) {
      out.unusable[s] = true;
      out.notices.push_back(fmt::format("{}: only {} readings", kSensorName[s], measured));
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      if (high[k] > low[k]) continue;
      out.unusable[s] = true;
      out.notices.push_back(fmt::format("{}_{}: every reading is {:.6g}: the axis is stuck or the column was filled in",
                                        kSensorName[s], "xyz"[k], low[k]));
    }
  }
}

void check_time(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  const double rate_hz = 1.0 / r.median_step_s();
  const double ratio = rate_hz / config.rate_hz;
  if (ratio > 500 || ratio < 1.0 / 500)
    out.notices.push_back(
        fmt::format("time: {:.4g} rows a second where the simulation says {:.4g}: the unit of the time column "
                    "is likely wrong (time_s, time_ms, time_us, time_ns)",
                    rate_hz, config.rate_hz));
  else if (ratio > 1.1 || ratio < 1 / 1.1)
    out.notices.push_back(
        fmt::format("time: {:.4g} rows a second, the simulation says rate_hz: {:.4g}; the recording's own times "
                    "are used",
                    rate_hz, config.rate_hz));
}

bool turns(const io::Recording& r, const sim::SimulationConfig& config) {
  const auto* gyro = triad(config, kGyr);
  if (gyro == nullptr || r.gyr_radps.empty()) return true;  // nothing that could say otherwise
  std::size_t moving = 0, measured = 0;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& y : r.gyr_radps)
    if (y.allFinite()) mean += y, ++measured;
  mean /= static_cast<double>(std::max<std::size_t>(measured, 1));
  for (const Vec3& y : r.gyr_radps) moving += y.allFinite() && (y - mean).norm() > 0.2;
  return static_cast<double>(moving) > 0.01 * static_cast<double>(r.size());
}

}  // namespace

Sanity check_input(const io::Recording& r, const sim::SimulationConfig& config) {
  Sanity out;
  const double duration_s = r.size() > 1 ? r.t_s(r.size() - 1) - r.t_s(0) : 0.0;
  if (r.size() < kLeastRows || (duration_s < kLeastDuration_s && r.size() < kManyRows)) {
    out.notices.push_back(
        fmt::format("too short: {} rows over {:.2f} s; record at least 30 s, better two minutes, with rests of "
                    "3 s between turns about all axes",
                    r.size(), duration_s));
    out.nothing_usable = true;
    return out;
  }
  check_columns(r, config, out);
  check_time(r, config, out);
  if (!out.unusable[kAcc])
    check_norm(kAcc, median_norm(r.acc_mps2), config.gravity_mps2,
               {{1.0 / kGravity_mps2, "g instead of m/s^2"},
                {1e3 / kGravity_mps2, "milli-g instead of m/s^2"},
                {kGravity_mps2, "m/s^2 multiplied by g once too often"}},
               out);
  if (!out.unusable[kMag])
    check_norm(kMag, median_norm(r.mag_uT), config.field_world_uT.norm(),
               {{10.0, "milligauss instead of uT"},
                {0.01, "gauss instead of uT"},
                {1e3, "nT instead of uT"},
                {1e-6, "tesla instead of uT"}},
               out);
  if (!out.unusable[kGyr]) check_rate_unit(r, config, out);
  if (!r.ref_q_world_body.empty()) detail::check_reference(r, config, out);
  if (!turns(r, config))
    out.notices.push_back(
        "no motion: only what shows at rest can be seen (temperature, supply, current, drift, lattice, noise); "
        "everything that needs rotation or acceleration stays untested");
  out.nothing_usable = out.unusable[kAcc] && out.unusable[kGyr] && out.unusable[kMag];
  return out;
}

}  // namespace stillpoint::diag

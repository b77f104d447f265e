/// Units that cannot be right, by the size of gravity, of the field and of the turns.
#include "diagnosis/sanity/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "diagnosis/sanity/sanity.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kBelieved = 2.2;   // a norm within this factor of the expected one is believed
constexpr double kHopeless = 20.0;  // no launch lasts at so many g, no magnet is so strong for most of a recording

/// Of the raw readings: the offset of the simulation taken away, in the right unit, would hide readings in a wrong one.
double median_norm(const std::vector<Vec3>& readings) {
  std::vector<double> norms;
  for (const Vec3& y : readings)
    if (y.allFinite()) norms.push_back(y.stableNorm());
  return median(std::move(norms));
}

void check_norm(Sensor s, double norm, double expected, std::span<const UnitMistake> units, Sanity& out) {
  if (!(expected > 0) || (norm < kBelieved * expected && norm > expected / kBelieved)) return;
  if (s == kMag && std::abs(norm - 1.0) < 0.05)
    return out.set_aside(s,
                         "mag: the norm of the readings is 1: they look normalised to unit length, and the strength of "
                         "the field is lost; record them in uT");
  if (const UnitMistake* unit = unit_of(norm / expected, units, 1.6))
    return out.set_aside(s, fmt::format("{}: the norm of the readings is {:.4g} where {:.4g} {} is expected: they look "
                                        "like {}; name the column after its unit or convert it",
                                        kSensorName[s], norm, expected, kSensorUnit[s], unit->words));
  if (!(norm < kHopeless * expected && norm > expected / kHopeless))
    return out.set_aside(s,
                         fmt::format("{}: the norm of the readings is {:.4g} where {:.4g} {} is expected: no customary "
                                     "unit; raw counts of the sensor, or damaged numbers? Convert them to {}",
                                     kSensorName[s], norm, expected, kSensorUnit[s], kSensorUnit[s]));
  if (s == kAcc) return;  // free fall and launches have any norm
  out.notices.push_back(
      fmt::format("{}: the norm of the readings is {:.4g} where the simulation has {:.4g} {}: "
                  "wrong field_world_uT, wrong unit or a magnet close by",
                  kSensorName[s], norm, expected, kSensorUnit[s]));
}

/// What raw readings of a vector are as large as, in the middle of all attitudes: an iron of 1 mT is most of them.
double usual_norm(double vector, const Vec3& offset) { return std::hypot(vector, offset.norm()); }

/// Readings of gravity under the name of a rate.
bool look_exchanged(const io::Recording& r, double gravity_mps2) {
  if (r.acc_mps2.empty() || r.gyr_radps.empty()) return false;
  const double gyr = median_norm(r.gyr_radps), acc = median_norm(r.acc_mps2);
  return gyr > gravity_mps2 / 1.2 && gyr < 1.2 * gravity_mps2 && acc < gravity_mps2 / kBelieved;
}

/// The change of the measured field against -omega x m over pieces of about 0.1 s: how many times too fast the
/// gyroscope turns it; none where the two do not go together.
std::optional<double> rate_over_field(const io::Recording& r, const sim::SimulationConfig& config, Sensor other) {
  const auto *gyro = triad(config, kGyr), *field = triad(config, other);
  const auto& v = triad(r, other);
  const double step_s = std::max(r.median_step_s(), 1e-9);
  const auto piece =
      static_cast<std::size_t>(std::clamp(std::round(0.1 / step_s), 1.0, 0.1 * static_cast<double>(r.size())));
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
  constexpr double kTogether = 0.4;
  if (!(pp > 0) || !(dd > 0) || !(pd > kTogether * std::sqrt(pp * dd))) return std::nullopt;
  return pp / pd;
}

}  // namespace

void check_rate_scale(double slope, const char* witness, const io::Recording& r, const sim::SimulationConfig& config,
                      Sanity& out) {
  constexpr double kSame = 1.5, kFarOff = 5.0;  // the means over a tenth of a second blunt fast turns
  const double clock = 1.0 / (r.median_step_s() * config.rate_hz);  // above 1: rows follow too fast
  const bool clock_is_off = clock > kFarOff || clock < 1 / kFarOff;
  if (clock_is_off && slope * clock < kSame && slope * clock > 1 / kSame) {
    out.mistake(
        fmt::format("time: {:.4g} rows a second where the simulation says rate_hz: {:.4g}, and the turns that "
                    "{} shows agree with the gyroscope only at that rate: the time column is not in the unit "
                    "of its name, or counts rows",
                    clock * config.rate_hz, config.rate_hz, witness));
    out.nothing_usable = true;
  } else if (const UnitMistake* unit = unit_of(slope, kRateUnits, kSame)) {
    out.set_aside(kGyr, fmt::format("gyr: turns {:.3g} times as fast as {}: the readings look like {}", slope, witness,
                                    unit->words));
  } else if (slope > kFarOff || slope < 1 / kFarOff) {
    out.set_aside(kGyr,
                  fmt::format("gyr: turns {:.3g} times as fast as {}: no customary unit; raw counts of the sensor, "
                              "or a wrong range setting? Convert the readings to rad/s",
                              slope, witness));
  }
}

void check_units(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  if (!out.unusable[kAcc] && !out.unusable[kGyr] && look_exchanged(r, config.gravity_mps2)) {
    out.set_aside(kAcc, "acc, gyr: gravity stands in the gyroscope's columns: the two sensors look exchanged");
    out.unusable[kGyr] = true;
  }
  if (!out.unusable[kAcc])
    check_norm(kAcc, median_norm(r.acc_mps2), usual_norm(config.gravity_mps2, triad(config, kAcc)->bias), kForceUnits,
               out);
  if (!out.unusable[kMag])
    check_norm(kMag, median_norm(r.mag_uT), usual_norm(config.field_world_uT.norm(), triad(config, kMag)->bias),
               kFieldUnits, out);
  const Sensor other = out.unusable[kMag] ? kAcc : kMag;
  if (out.unusable[kGyr] || out.unusable[other]) return;
  if (const auto slope = rate_over_field(r, config, other))
    check_rate_scale(*slope, other == kMag ? "the measured field" : "measured gravity", r, config, out);
}

}  // namespace stillpoint::diag::detail

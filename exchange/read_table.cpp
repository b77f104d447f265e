#include "exchange/read_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/median.h"
#include "core/nearest.h"
#include "core/units.h"
#include "exchange/order.h"

namespace stillpoint::exchange {
namespace {

/// 73 years: an origin and a time after it, twice, still fit. Unix time in ns is 1.8e18.
constexpr std::int64_t kFurthest_ns = 2'300'000'000'000'000'000;

double median_norm(const Stream& s) {
  std::vector<double> norms;
  for (const Vec3& v : s.values) norms.push_back(v.norm());
  return median(std::move(norms));
}

std::string at(const Table& table) { return fmt::format("{}:{}", table.name, table.lines.front() - 1); }

Result<const Column*> find(const Table& table, const std::string& name) {
  if (const Column* c = table.find(name)) return c;
  std::vector<std::string> names;
  for (const Column& c : table.columns) names.push_back(c.name);
  const auto meant = nearest(name, names);
  return fail(ErrorKind::kBadData,
              meant.empty()
                  ? fmt::format("{}: no column '{}'; these are there: {}", at(table), name, fmt::join(names, ", "))
                  : fmt::format("{}: no column '{}'; did you mean '{}'?", at(table), name, meant));
}

/// ns for one unit of the time column: by the map, its name, or the step between rows.
Result<double> time_unit(const Table& table, const Column& time, const ColumnMap& map, std::vector<std::string>& why) {
  const std::string named = map.time_unit.empty() ? unit_in(time.name) : map.time_unit;
  if (const double ns = time_factor_ns(named); ns != 0.0) return ns;
  std::vector<double> steps;
  for (std::size_t i = 1; i < time.values.size(); ++i)
    if (time.values[i] > time.values[i - 1]) steps.push_back(time.values[i] - time.values[i - 1]);
  const double step = median(std::move(steps));
  constexpr double kFastest_s = 0.001, kSlowest_s = 0.05;  // 20 Hz to 1 kHz: the units lie a factor of 1000 apart
  for (const auto& [unit, ns] : {std::pair{"s", 1e9}, {"ms", 1e6}, {"us", 1e3}, {"ns", 1.0}}) {
    const double step_s = 1e-9 * ns * step;
    if (step_s < 0.99 * kFastest_s || step_s > 1.01 * kSlowest_s) continue;
    why.push_back(fmt::format("{}: column '{}' looks like {}: {:.4g} Hz", table.name, time.name, unit, 1.0 / step_s));
    return ns;
  }
  return fail(ErrorKind::kBadData,
              fmt::format("{}: the unit of column '{}' cannot be told from its step of {:g}; say it in a map: time: "
                          "{{column: '{}', unit: ms}}",
                          at(table), time.name, step, time.name));
}

Result<Stream> raw_stream(const Table& table, const Column& time, double unit_ns, const SensorColumns& wanted) {
  std::vector<const Column*> columns;
  for (const auto& name : wanted.columns) {
    const auto column = find(table, name);
    if (!column) return tl::unexpected(column.error());
    columns.push_back(*column);
  }
  Stream s{wanted.quantity, fmt::format("{} ({})", table.name, fmt::join(wanted.columns, ", ")), {}, {}};
  std::int64_t origin_ns = 0;
  if (__builtin_mul_overflow(time.origin, static_cast<std::int64_t>(unit_ns), &origin_ns) || origin_ns > kFurthest_ns ||
      origin_ns < -kFurthest_ns)
    return fail(ErrorKind::kBadData, fmt::format("{}: column '{}' begins at {} units of {:g} ns, 73 years at most are "
                                                 "allowed; say its unit in a map",
                                                 at(table), time.name, time.origin, unit_ns));
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Vec3 v = Vec3::Zero();
    for (std::size_t k = 0; k < columns.size(); ++k)
      v[static_cast<Eigen::Index>(k)] = columns[k]->values[i] + static_cast<double>(columns[k]->origin);
    const double t = unit_ns * time.values[i];
    if (std::isfinite(t) && std::abs(t) < static_cast<double>(kFurthest_ns) && v.allFinite())
      s.add(origin_ns + std::llround(t), v);
  }
  return s;
}

struct Candidate {
  const char* unit;
  double low, high;  ///< of the median norm in this unit
};
constexpr Candidate kAccUnits[] = {{"m/s^2", 9.2, 10.4}, {"g", 0.94, 1.06}, {"mg", 940.0, 1060.0}};
// The Earth's field has 22 to 67 uT; hard iron of a board not taken off yet may double it.
constexpr Candidate kMagUnits[] = {
    {"uT", 15.0, 140.0}, {"gauss", 0.15, 1.4}, {"mgauss", 150.0, 1400.0}, {"nT", 15e3, 140e3}, {"T", 15e-6, 140e-6}};

template <std::size_t N>
std::optional<std::string> unit_of_norm(const Candidate (&units)[N], double norm) {
  for (const Candidate& c : units)
    if (norm > c.low && norm < c.high) return c.unit;
  return std::nullopt;
}

Error unknown_unit(const Table& table, const SensorColumns& s, double norm, const std::string& hint) {
  return {ErrorKind::kBadData,
          fmt::format("{}: the unit of {} cannot be told: median norm {:.4g}{}; say it in a map: {}: {{columns: [{}], "
                      "unit: ...}}",
                      at(table), fmt::join(s.columns, ", "), norm, hint, name(s.quantity), fmt::join(s.columns, ", "))};
}

/// By gravity: it is in every accelerometer, in every unit.
Result<double> acc_factor(const Table& table, const SensorColumns& s, const Stream& stream,
                          std::vector<std::string>& why) {
  const double norm = median_norm(stream), named = factor_of(Quantity::kAcc, s.unit);
  const auto seen = unit_of_norm(kAccUnits, norm);
  if (named != 0.0 && (!seen || factor_of(Quantity::kAcc, *seen) == named)) {
    if (norm * named > 3.0) return named;
  } else if (seen) {
    why.push_back(fmt::format("{}: {} looks like {}: median norm {:.4g}{}", table.name, fmt::join(s.columns, ", "),
                              *seen, norm, named != 0.0 ? fmt::format(", although its name says {}", s.unit) : ""));
    return factor_of(Quantity::kAcc, *seen);
  }
  const bool bare = norm * (named != 0.0 ? named : 1.0) < 3.0;
  return tl::unexpected(unknown_unit(
      table, s, norm, bare ? "; gravity seems to be taken out, record the accelerometer with gravity" : ""));
}

Result<double> mag_factor(const Table& table, const SensorColumns& s, const Stream& stream,
                          std::vector<std::string>& why) {
  if (const double named = factor_of(Quantity::kMag, s.unit); named != 0.0) return named;
  const double norm = median_norm(stream);
  const auto seen = unit_of_norm(kMagUnits, norm);
  if (!seen) return tl::unexpected(unknown_unit(table, s, norm, ""));
  why.push_back(
      fmt::format("{}: {} looks like {}: median norm {:.4g}", table.name, fmt::join(s.columns, ", "), *seen, norm));
  return factor_of(Quantity::kMag, *seen);
}

/// By how fast gravity turns in the sensor's frame, else by rates that only one unit allows.
Result<double> gyr_factor(const Table& table, const SensorColumns& s, const Stream& gyr, const Stream* acc,
                          std::vector<std::string>& why) {
  const auto [turning, same_axes] = acc == nullptr ? GravityTurn{} : turn_of_gravity(*acc, gyr);
  const double named = factor_of(Quantity::kGyr, s.unit);
  const auto agrees = [turning = turning](double factor) { return turning > 0.3 * factor && turning < 3.0 * factor; };
  if (named != 0.0 && (turning == 0.0 || agrees(named))) return named;
  const bool may_overrule = named == 0.0 || same_axes;  // other axes give a small factor too, which is no unit's
  for (const char* unit : {"rad/s", "deg/s", "mdps"})
    if (const double factor = factor_of(Quantity::kGyr, unit); may_overrule && agrees(factor)) {
      why.push_back(fmt::format("{}: {} looks like {}: gravity turns by {:.3g} rad/s for each unit{}", table.name,
                                fmt::join(s.columns, ", "), unit, turning,
                                named != 0.0 ? fmt::format(", although its name says {}", s.unit) : ""));
      return factor;
    }
  if (named != 0.0) {
    why.push_back(
        fmt::format("WARNING {}: gravity turns {:.2g} times as fast as {} says; are its axes, signs or its "
                    "unit those of the accelerometer?",
                    table.name, turning / named, fmt::join(s.columns, ", ")));
    return named;
  }
  double fastest = 0.0;
  for (const Vec3& v : gyr.values) fastest = std::max(fastest, v.cwiseAbs().maxCoeff());
  constexpr double kFullScale_radps = 70.0;  // 4000 deg/s, the widest range on the market
  if (fastest > kFullScale_radps) {
    why.push_back(
        fmt::format("{}: {} looks like deg/s: it reaches {:.4g}", table.name, fmt::join(s.columns, ", "), fastest));
    return kRadPerDeg;
  }
  return tl::unexpected(unknown_unit(table, s, median_norm(gyr), ", and the motion does not tell"));
}

/// Of all orders and signs of the gyroscope's axes the one that agrees best.
double best_agreement(const Mat3& along) {
  double best = 0.0;
  std::array<Eigen::Index, 3> axes{0, 1, 2};
  do {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < 3; ++i) sum += std::abs(along(i, axes[static_cast<std::size_t>(i)]));
    best = std::max(best, sum);
  } while (std::next_permutation(axes.begin(), axes.end()));
  return best;
}

}  // namespace

GravityTurn turn_of_gravity(const Stream& acc, const Stream& gyr) {
  double length = 0.0;
  Mat3 along = Mat3::Zero();  // of each axis that gravity turns about with each axis of the gyroscope
  std::size_t k = 0;
  constexpr std::size_t kStride = 5;  // differences over five readings: less noise
  for (std::size_t i = kStride; i + kStride < acc.t_ns.size(); ++i) {
    const double dt_s = in_seconds(acc.t_ns[i + kStride] - acc.t_ns[i - kStride]);
    const Vec3 &before = acc.values[i - kStride], &after = acc.values[i + kStride], &f = acc.values[i];
    const auto is_gravity = [](const Vec3& v) { return std::abs(v.norm() - kStandardGravity_mps2) < 0.6; };
    if (dt_s <= 0.0 || dt_s > 0.5 || !is_gravity(before) || !is_gravity(after) || !is_gravity(f)) continue;
    while (k + 1 < gyr.t_ns.size() && gyr.t_ns[k + 1] <= acc.t_ns[i]) ++k;
    if (gyr.values.empty()) break;
    // df/dt of what stands still in the world is f x omega; its part along the change is omega (change x f).
    along += ((after - before) / dt_s).cross(f) * gyr.values[k].transpose();
    length += f.cross(gyr.values[k]).squaredNorm();
  }
  // Below some turns in all the noise of the accelerometer decides.
  constexpr double kLeastTurning = 50.0;  // (m/s^3)^2 summed, for the factor of rad/s
  const double factor = length > 0.0 ? along.trace() / length : 0.0;
  if (factor * factor * length <= kLeastTurning) return {};
  return {factor, along.trace() > 0.9 * best_agreement(along)};
}

Result<std::vector<Stream>> read_streams(const Table& table, const ColumnMap& map, std::vector<std::string>& why) {
  const std::string time_name = map.time.empty() ? time_column(table) : map.time;
  if (time_name.empty())
    return fail(ErrorKind::kBadData, fmt::format("{}: no column looks like the time; say it in a map: time: {{column: "
                                                 "..., unit: s}}",
                                                 at(table)));
  const auto time = find(table, time_name);
  if (!time) return tl::unexpected(time.error());
  const auto unit_ns = time_unit(table, **time, map, why);
  if (!unit_ns) return tl::unexpected(unit_ns.error());
  std::vector<Stream> streams;
  for (const SensorColumns& wanted : map.sensors) {
    if (table.name.find(wanted.table) == std::string::npos) continue;
    auto s = raw_stream(table, **time, *unit_ns, wanted);
    if (!s) return tl::unexpected(s.error());
    if (s->values.empty()) {
      why.push_back(fmt::format("not used: {}: no row has all of these", s->from));
      continue;
    }
    if (wanted.quantity != Quantity::kTemp)  // before gravity is compared: the accelerometer is turned already
      for (Vec3& v : s->values) v = map.R_body_sensor * v;
    put_in_order(*s, why);  // neighbours of a jump in time would turn gravity by nothing that was measured
    const auto acc =
        std::find_if(streams.begin(), streams.end(), [](const Stream& x) { return x.quantity == Quantity::kAcc; });
    const Stream* const force = acc == streams.end() ? nullptr : &*acc;
    const Result<double> factor = wanted.quantity == Quantity::kAcc   ? acc_factor(table, wanted, *s, why)
                                  : wanted.quantity == Quantity::kGyr ? gyr_factor(table, wanted, *s, force, why)
                                  : wanted.quantity == Quantity::kMag ? mag_factor(table, wanted, *s, why)
                                                                      : Result<double>(1.0);
    if (!factor) return tl::unexpected(factor.error());
    Stream out{s->quantity, s->from, {}, {}};
    for (std::size_t i = 0; i < s->values.size(); ++i)
      if (const Vec3 v = *factor * s->values[i]; v.allFinite()) out.add(s->t_ns[i], v);
    streams.push_back(std::move(out));
  }
  return streams;
}

}  // namespace stillpoint::exchange

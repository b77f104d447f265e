#include "diagnosis/no_reference/field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kCell_s = 0.5, kMargin_s = 0.5, kBridge_s = 2.0, kTurn_s = 20.0, kLeast_s = 1.0;
constexpr double kSameTilt_rad = 0.1;
constexpr std::size_t kLeastAlike = 12;  // cells in the same tilt, to know what is usual there
constexpr double kOverUsual = 6.0;       // of a cell's departure, in the usual one
constexpr double kLeast_uT = 1.0;        // smaller ones are left to the calibration
constexpr double kMostOfRecording = 0.33;
constexpr double kTurned_rad = 0.5;  // a turn by this much tells what is fixed in the body from the world

struct Interval {
  double begin_s = 0.0, end_s = 0.0;
};

/// Means over half a second of rest.
struct Cell {
  std::size_t first = 0, last = 0;  ///< rows, inclusive
  Vec3 up, field;
  double departure_uT = 0.0;
};

std::vector<Cell> cells_of(const io::Recording& r, const sim::SimulationConfig& simulation, const Forensics& raw,
                           const std::vector<RestWindow>& rest) {
  const auto n = std::max<std::size_t>(2, static_cast<std::size_t>(std::lround(kCell_s / r.median_step_s())));
  std::vector<Cell> cells;
  for (const auto& w : rest)
    for (std::size_t i = w.first; i + n <= w.last + 1; i += n) {
      Cell c{i, i + n - 1, Vec3::Zero(), Vec3::Zero()};
      double count = 0;
      for (std::size_t k = c.first; k <= c.last; ++k) {
        if (!r.mag_uT[k].allFinite() || !r.acc_mps2[k].allFinite() || raw.muted(kMag, k)) continue;
        c.up += corrected(*simulation.accelerometer, r.acc_mps2[k]);
        c.field += corrected(*simulation.magnetometer, r.mag_uT[k]);
        ++count;
      }
      if (count < 2) continue;
      c.up.normalize();
      c.field /= count;
      cells.push_back(c);
    }
  return cells;
}

/// Departure of strength and of the part along gravity from what is usual in this tilt.
void measure(std::vector<Cell>& cells) {
  for (Cell& c : cells) {
    std::vector<double> strength, along;
    for (const Cell& o : cells) {
      if (std::acos(std::clamp(c.up.dot(o.up), -1.0, 1.0)) > kSameTilt_rad) continue;
      strength.push_back(o.field.norm()), along.push_back(o.field.dot(o.up));
    }
    if (strength.size() < kLeastAlike) continue;
    c.departure_uT = std::hypot(c.field.norm() - median(strength), c.field.dot(c.up) - median(along));
  }
}

std::vector<Interval> disturbed(const io::Recording& r, const std::vector<Cell>& cells) {
  std::vector<double> all;
  all.reserve(cells.size());
  for (const Cell& c : cells) all.push_back(c.departure_uT);
  const double limit = std::max(kLeast_uT, kOverUsual * median(all));
  std::vector<Interval> found;
  bool was = false;  // the rest before is disturbed too: one disturbance, during which the body was turned
  for (const Cell& c : cells) {
    const bool is = c.departure_uT >= limit;
    was = was && !found.empty() && found.back().end_s - found.back().begin_s >= kLeast_s;
    if (is && !found.empty() && r.t_s(c.first) - found.back().end_s < (was ? kTurn_s : kBridge_s))
      found.back().end_s = r.t_s(c.last);
    else if (is)
      found.push_back({r.t_s(c.first), r.t_s(c.last)});
    was = is;
  }
  std::erase_if(found, [](const Interval& i) { return i.end_s - i.begin_s < kLeast_s; });
  return found;
}

/// What stands in the field beyond the last undisturbed rest's, carried along by the gyroscope; from body and world.
struct Disturbance {
  Vec3 body = Vec3::Zero(), world = Vec3::Zero();
  double scatter_body = 0.0, scatter_world = 0.0, turn_rad = 0.0;
};

Disturbance follow(const io::Recording& r, const sim::SimulationConfig& simulation, const std::vector<Cell>& cells,
                   const Interval& v) {
  const Cell* before = nullptr;
  for (const Cell& c : cells)
    if (r.t_s(c.last) < v.begin_s) before = &c;
  Disturbance d;
  if (before == nullptr) return d;
  Vec3 offset = Vec3::Zero();
  for (std::size_t i = before->first; i <= before->last; ++i)
    offset += r.gyr_radps[i] / static_cast<double>(before->last - before->first + 1);
  Quat q = Quat::Identity(), q_begin = q;  // body to the body as it lay before
  std::vector<Vec3> body, world;
  for (std::size_t i = before->last + 1; i < r.size() && r.t_s(i) <= v.end_s; ++i) {
    if (r.gyr_radps[i].allFinite())
      q = (q * exp_quat((r.t_s(i) - r.t_s(i - 1)) * (simulation.gyroscope->matrix * (r.gyr_radps[i] - offset))))
              .normalized();
    if (r.t_s(i) < v.begin_s || !r.mag_uT[i].allFinite()) {
      q_begin = q;
      continue;
    }
    d.turn_rad = std::max(d.turn_rad, log_quat(q_begin.conjugate() * q).norm());
    body.push_back(corrected(*simulation.magnetometer, r.mag_uT[i]) - q.conjugate() * before->field);
    world.push_back(q * body.back());
  }
  const auto n = static_cast<double>(std::max<std::size_t>(body.size(), 1));
  for (std::size_t i = 0; i < body.size(); ++i) d.body += body[i] / n, d.world += world[i] / n;
  for (std::size_t i = 0; i < body.size(); ++i)
    d.scatter_body += (body[i] - d.body).squaredNorm() / n, d.scatter_world += (world[i] - d.world).squaredNorm() / n;
  return d;
}

Finding describe(const Disturbance& d, const Interval& v) {
  Finding f;
  f.channels = {"mag_x", "mag_y", "mag_z"};
  f.interval_s = {v.begin_s, v.end_s};
  f.driver = "time: something near the sensor that came and went";
  f.equation = "m = R^T m_w + b between the two times";
  const bool turned = d.turn_rad > kTurned_rad;
  const bool is_body = turned && d.scatter_body < 0.5 * d.scatter_world;
  const bool is_world = turned && d.scatter_world < 0.5 * d.scatter_body;
  f.effect = is_body ? "mag_hard_step" : is_world ? "mag_field_step" : "unknown:m(t)";
  if (!is_body && !is_world) f.equivalent = {"mag_field_step", "mag_hard_step"};
  f.regime = fmt::format(
      "from {:.1f} to {:.1f} s only; the field differs by {:.1f} uT; {}", v.begin_s, v.end_s, d.body.norm(),
      is_body    ? "the difference turns with the body: something was attached to it"
      : is_world ? "the difference stands in the world while the body turns: something was laid beside it"
      : turned   ? "neither fixed in the body nor in the world: a source close by, or one that moves"
                 : fmt::format("the body turned by {:.0f} degrees meanwhile, too little to tell a source on the body "
                                 "from one in the world",
                               d.turn_rad * kDegPerRad));
  const Vec3& b = is_world ? d.world : d.body;
  const double half = 1.96 * std::sqrt((is_world ? d.scatter_world : d.scatter_body) / 3.0);
  for (int k = 0; k < 3; ++k)
    f.parameters.push_back(
        {fmt::format("b_{}{}", is_world ? "w" : "", "xyz"[k]), b[k], {b[k] - half, b[k] + half}, "uT"});
  f.decided_by = "turn the body by 90 degrees while the disturbance lasts";
  f.held_out.unit = "uT";
  return f;
}

}  // namespace

DisturbedField find_disturbed_field(const io::Recording& r, const sim::SimulationConfig& simulation,
                                    const Forensics& raw, const std::vector<RestWindow>& rest) {
  DisturbedField out{{}, raw};
  if (!simulation.magnetometer || r.mag_uT.empty() || !r.current_A.empty()) return out;
  auto cells = cells_of(r, simulation, raw, rest);
  measure(cells);
  const auto intervals = disturbed(r, cells);
  if (intervals.empty()) return out;
  double disturbed_s = 0.0;
  for (const Interval& v : intervals) disturbed_s += v.end_s - v.begin_s;
  const double from = r.t_s(0), to = r.t_s(r.size() - 1);
  const bool lasts = intervals.back().end_s > to - kBridge_s || intervals.front().begin_s < from + kBridge_s;
  if (lasts || disturbed_s > kMostOfRecording * (to - from)) return out;
  auto& muted = out.masked.sensor[kMag].muted;
  if (muted.empty()) muted.assign(r.size(), 0);
  for (const Interval& v : intervals) {
    out.findings.push_back(describe(follow(r, simulation, cells, v), v));
    for (std::size_t i = 0; i < r.size(); ++i)
      if (r.t_s(i) > v.begin_s - kMargin_s && r.t_s(i) < v.end_s + kMargin_s) muted[i] = 1;
  }
  return out;
}

}  // namespace stillpoint::diag::detail

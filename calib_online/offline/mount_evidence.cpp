#include "calib_online/offline/mount_evidence.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/directions.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kSamePlacement_rad = 10.0 * kRadPerDeg, kSameGravity_rad = 3.0 * kRadPerDeg;
constexpr double kPointsApart_rad = 10.0 * kRadPerDeg;
constexpr double kLongestStep_s = 0.25;  // as the rest detector's of a quarter of two seconds

using Samples = std::vector<RawSample>;

bool is_rest(const Window& w) {
  const bool steady =
      w.refusal == Refusal::kNone || w.refusal == Refusal::kNotGravity || w.refusal == Refusal::kUnknownRate;
  return steady && (w.has & kAcc) != 0;
}

std::vector<Window> windows_of(const Samples& samples, const RestDetectorParams& params) {
  RestDetector detector(params);
  const CalibrationSnapshot nothing_known;
  std::vector<Window> windows;
  for (const RawSample& sample : samples)
    if (const auto window = detector.push(sample, nothing_known); window && is_rest(*window))
      windows.push_back(*window);
  return windows;
}

MountRest rest_of(const Window& w, std::size_t recording) {
  MountRest rest{recording, w.t_start_ns, w.t_end_ns, 1, vec(w.acc_mps2), vec(w.gyr_radps), vec(w.mag_uT)};
  rest.acc_var = mat(w.acc_cov).trace() / 3.0;
  rest.has_gyr = (w.has & kGyr) != 0;
  rest.has_mag = (w.has & kMag) != 0;
  return rest;
}

/// Means over both.
void join(MountRest& rest, const MountRest& more) {
  const double all = rest.windows + more.windows, a = rest.windows / all, b = more.windows / all;
  rest.acc_mps2 = a * rest.acc_mps2 + b * more.acc_mps2;
  rest.acc_var = a * a * rest.acc_var + b * b * more.acc_var;
  rest.has_gyr = rest.has_gyr && more.has_gyr;
  rest.has_mag = rest.has_mag && more.has_mag;
  rest.gyr_radps = a * rest.gyr_radps + b * more.gyr_radps;
  rest.mag_uT = a * rest.mag_uT + b * more.mag_uT;
  rest.windows += more.windows;
  rest.t_end_ns = more.t_end_ns;
}

/// Trapezoid over each step; none where readings are missing on the way.
std::optional<MountTurn> turn_between(const Samples& samples, const MountRest& from, const MountRest& to) {
  if (!from.has_gyr || !to.has_gyr) return std::nullopt;
  const Vec3 bias_radps = 0.5 * (from.gyr_radps + to.gyr_radps);
  MountTurn turn;
  MountWay& way = turn.whole;
  std::int64_t last_ns = 0;
  Vec3 last = Vec3::Zero();
  double since_point_rad = 0.0;
  const auto after = [](const RawSample& s, std::int64_t t_ns) { return s.t_ns < t_ns; };
  for (auto s = std::lower_bound(samples.begin(), samples.end(), from.t_end_ns, after);
       s != samples.end() && s->t_ns <= to.t_start_ns; ++s) {
    if (s->holds(kGyr) && vec(s->gyr_radps).allFinite()) {
      const Vec3 rate = vec(s->gyr_radps) - bias_radps;
      if (last_ns != 0) {
        const double dt_s = in_seconds(s->t_ns - last_ns);
        if (dt_s > kLongestStep_s) return std::nullopt;
        const Vec3 mean = 0.5 * (rate + last);
        way.as_read.advance(mean, Mat3::Identity(), dt_s);
        way.negated.advance(-mean, Mat3::Identity(), dt_s);
        way.duration_s += dt_s;
        since_point_rad += mean.norm() * dt_s;
      }
      last_ns = s->t_ns;
      last = rate;
    }
    if (last_ns != 0 && s->t_ns == last_ns && s->holds(kAcc) && vec(s->acc_mps2).allFinite() &&
        since_point_rad >= kPointsApart_rad) {
      turn.points.push_back(way);
      MountWay& point = turn.points.back();
      point.acc_mps2 = vec(s->acc_mps2);
      point.has_mag = s->holds(kMag) && vec(s->mag_uT).allFinite();
      if (point.has_mag) point.mag_uT = vec(s->mag_uT);
      since_point_rad = 0.0;
    }
  }
  if (last_ns == 0 && to.t_start_ns - from.t_end_ns > static_cast<std::int64_t>(1e9 * kLongestStep_s))
    return std::nullopt;
  way.acc_mps2 = to.acc_mps2;
  way.mag_uT = to.mag_uT;
  way.has_mag = to.has_mag;
  return turn;
}

bool same_placement(const MountRest& a, const MountRest& b, const std::optional<MountTurn>& turn) {
  if (angle_rad(a.acc_mps2, b.acc_mps2) > kSameGravity_rad) return false;
  return !turn || log_quat(turn->whole.as_read.q).norm() < kSamePlacement_rad;
}

}  // namespace

MountEvidence mount_evidence(std::span<const std::vector<RawSample>> recordings, const RestDetectorParams& params) {
  MountEvidence out;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const Samples& samples = recordings[r];
    for (const RawSample& s : samples) {
      out.has_gyr = out.has_gyr || s.holds(kGyr);
      out.has_mag = out.has_mag || s.holds(kMag);
    }
    bool first = true;
    for (const Window& window : windows_of(samples, params)) {
      const MountRest next = rest_of(window, r);
      if (!first) {
        MountRest& now = out.rests.back();
        auto turn = turn_between(samples, now, next);
        if (same_placement(now, next, turn)) {
          join(now, next);
          continue;
        }
        out.broken_turns += turn || !out.has_gyr ? 0 : 1;
        if (turn) {
          turn->from = out.rests.size() - 1;
          turn->to = out.rests.size();
          out.turns.push_back(std::move(*turn));
        }
      }
      out.rests.push_back(next);
      first = false;
    }
  }
  return out;
}

}  // namespace stillpoint::calib

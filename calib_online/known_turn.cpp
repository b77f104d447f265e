#include "calib_online/known_turn.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "core/median.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kTellsOfScale_rad = 20.0 * kRadPerDeg;  // less is no turn that tells a scale
constexpr double kRest_radps = 3.0 * kRadPerDeg;  // a hand that holds still is far below, one that turns far above
constexpr double kSteady = 0.05;                  // rms about the mean rate
constexpr double kBlock_s = 0.1;                  // the axis and the rate are seen in such parts, noise is not
constexpr double kBlock_rad = 0.1;                // a fast turn in shorter ones
constexpr double kGapSteps = 2.5;                 // as in the reader of recordings
constexpr std::size_t kFewest = 10;
constexpr int kPlateau = 4;           // readings at the greatest value
constexpr std::size_t kRunUp = 3;     // readings that lead there
constexpr double kRunUp_steps = 8.0;  // of the lattice, in these: a slow maximum comes by ones

struct Reading {
  double t_s;
  Vec3 y;
};

template <class... Numbers>
tl::unexpected<Error> refused(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  return fail(ErrorKind::kBadData, text);
}

Reading between(const Reading& a, const Reading& b, double t_s) {
  const double share = b.t_s > a.t_s ? (t_s - a.t_s) / (b.t_s - a.t_s) : 0.0;
  return {t_s, a.y + share * (b.y - a.y)};
}

/// The readings from the last one before the span to the first one after.
std::vector<Reading> around(const StatedTurn& stated, std::span<const std::int64_t> t_ns, std::span<const Vec3> y) {
  std::vector<Reading> out;
  for (std::size_t k = 0; k < y.size(); ++k) {
    if (!y[k].allFinite()) continue;
    const Reading now{in_seconds(t_ns[k] - t_ns[0]), y[k]};
    if (now.t_s <= stated.begin_s) out.clear();
    out.push_back(now);
    if (now.t_s >= stated.end_s) break;
  }
  return out;
}

double median_step(const std::vector<Reading>& r) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < r.size(); ++k) steps.push_back(r[k].t_s - r[k - 1].t_s);
  return median(std::move(steps));
}

/// The moment from which an axis stays at its greatest reading to the last bit, having come there with a stride.
std::optional<Reading> clipped(const std::vector<Reading>& r) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    double greatest = 0.0, lattice = 1e9;
    for (const Reading& one : r) greatest = std::max(greatest, std::abs(one.y[axis]));
    for (std::size_t k = 1; k < r.size(); ++k)
      if (const double step = std::abs(r[k].y[axis] - r[k - 1].y[axis]); step > 0.0) lattice = std::min(lattice, step);
    int same = 0;
    std::size_t from = 0;
    for (std::size_t k = 1; k < r.size(); ++k) {
      if (r[k].y[axis] != r[k - 1].y[axis]) same = 0, from = k;
      const bool rail = std::abs(r[k].y[axis]) == greatest && ++same >= kPlateau && from > 0;
      const std::size_t before = from - std::min(from, kRunUp);
      if (rail && std::abs(r[from].y[axis] - r[before].y[axis]) > kRunUp_steps * lattice) return r[from];
    }
  }
  return std::nullopt;
}

/// A part of the turn.
struct Block {
  Vec3 integral_rad = Vec3::Zero();
  double duration_s = 0.0;
  [[nodiscard]] Vec3 rate() const { return integral_rad / duration_s; }
};

std::vector<Block> blocks(const std::vector<Reading>& r, const Vec3& bias) {
  std::vector<Block> out(1);
  for (std::size_t k = 1; k < r.size(); ++k) {
    if (out.back().duration_s >= kBlock_s || out.back().integral_rad.norm() >= kBlock_rad) out.emplace_back();
    const double dt_s = r[k].t_s - r[k - 1].t_s;
    out.back().integral_rad += (0.5 * (r[k].y + r[k - 1].y) - bias) * dt_s;
    out.back().duration_s += dt_s;
  }
  return out;
}

/// What is mean and what is scatter in the blocks, about their common axis and across it.
struct Course {
  double across = 0.0;              ///< rms of the rate across the axis over rms of the rate
  double uneven = 0.0;              ///< rms of the rate about its mean, over that
  double least = 1e9, most = -1e9;  ///< rate, rad/s
};

Course course(const std::vector<Block>& parts, const Vec3& integral_rad, double duration_s) {
  const Vec3 axis = integral_rad.normalized();
  const double mean = integral_rad.norm() / duration_s;
  double across = 0.0, all = 0.0, scatter = 0.0;
  Course c;
  for (const Block& b : parts) {
    const double along = b.rate().dot(axis);
    all += b.rate().squaredNorm() * b.duration_s;
    across += (b.rate() - along * axis).squaredNorm() * b.duration_s;
    scatter += (along - mean) * (along - mean) * b.duration_s;
    c.least = std::min(c.least, along);
    c.most = std::max(c.most, along);
  }
  c.across = std::sqrt(across / all);
  c.uneven = std::sqrt(scatter / duration_s) / mean;
  return c;
}

}  // namespace

double AngleSeen::residual_sd(double stated_rad) const noexcept {
  return (angle_rad - stated_rad) / std::sqrt(own_var);
}

double AngleSeen::chi2(double stated_rad) const noexcept {
  return (angle_rad - stated_rad) * (angle_rad - stated_rad) / (own_var + matrix_var);
}

AngleSeen seen_by(const GyroMatrixFit& fit, const KnownTurn& turn) noexcept {
  const Vec3 turned = fit.H * turn.integral_rad;
  const Vec3 u = turned.normalized();
  Mat39 by_rows = Mat39::Zero();
  for (int i = 0; i < 3; ++i) by_rows.block<1, 3>(i, 3 * i) = turn.integral_rad.transpose();
  const Mat3 of_matrix = by_rows * fit.covariance * by_rows.transpose();
  AngleSeen seen;
  seen.angle_rad = turned.norm();
  seen.matrix_var = u.dot(of_matrix * u);
  // What lies across u lengthens the turn by half its square: two moments of that, as of a Gaussian.
  const Mat3 keep_across = Mat3::Identity() - u * u.transpose();
  const Mat3 across = keep_across * of_matrix * keep_across;
  const double of_square = 0.25 * (across.trace() * across.trace() + 2.0 * across.squaredNorm());
  const Vec3 lever = fit.H.transpose() * u;
  seen.own_var = turn.variance_rad2 + lever.dot(turn.integral_of_bias * lever) + of_square / turned.squaredNorm();
  return seen;
}

void add_known_turn(const GyroMatrixFit& fit, const KnownTurn& turn, GyroMatrixSums& sums) noexcept {
  const Vec3 u = (fit.H * turn.integral_rad).normalized();
  sums.add_angle(u, turn.integral_rad, turn.angle_rad, seen_by(fit, turn).own_var);
}

Result<KnownTurn> known_turn(const StatedTurn& stated, std::span<const std::int64_t> t_ns,
                             std::span<const Vec3> gyr_radps, const Vec3& bias_radps, const Mat3& bias_covariance) {
  if (t_ns.empty() || gyr_radps.empty()) return fail(ErrorKind::kBadData, "the recording holds no gyroscope");
  const double lasts_s = in_seconds(t_ns.back() - t_ns.front());
  if (stated.begin_s < 0.0 || stated.end_s > lasts_s)
    return refused("from %g to %g s, but the recording lasts %.3f s; times are seconds since its first row",
                   stated.begin_s, stated.end_s, lasts_s);
  std::vector<Reading> r = around(stated, t_ns, gyr_radps);
  if (r.size() < kFewest || r.front().t_s > stated.begin_s || r.back().t_s < stated.end_s)
    return refused("the gyroscope was read %zu times from %g to %g s, ten are the least; state a span that it covers",
                   r.size(), stated.begin_s, stated.end_s);
  const double step_s = median_step(r);
  for (std::size_t k = 1; k < r.size(); ++k)
    if (r[k].t_s - r[k - 1].t_s > kGapSteps * step_s)
      return refused(
          "no reading of the gyroscope from %.3f to %.3f s, and what it turned there is not known; state a "
          "span without the gap, or turn again",
          r[k - 1].t_s, r[k].t_s);
  if (const auto rail = clipped(r))
    return refused(
        "the gyroscope is clipped from %.3f s on: an axis stays at its greatest reading; turn more slowly, or "
        "set a wider range",
        rail->t_s);
  r.front() = between(r[0], r[1], stated.begin_s);
  r.back() = between(r[r.size() - 2], r.back(), stated.end_s);

  const std::vector<Block> parts = blocks(r, bias_radps);
  const double duration_s = stated.end_s - stated.begin_s;
  KnownTurn turn;
  for (const Block& b : parts) turn.integral_rad += b.integral_rad;
  const double read_rad = turn.integral_rad.norm();
  if (read_rad < kTellsOfScale_rad)
    return refused("it turns by %.1f deg only, and 20 are the least; is it the right span?", read_rad * kDegPerRad);
  const Course c = course(parts, turn.integral_rad, duration_s);
  if (stated.steady && c.uneven > kSteady)
    return refused("the rate is not steady, it goes from %.4g to %.4g deg/s; state a span in which it is",
                   c.least * kDegPerRad, c.most * kDegPerRad);
  for (const Block* end : {&parts.front(), &parts.back()})
    if (const double rate = end->rate().norm(); !stated.steady && rate > kRest_radps)
      return refused("at %g s it turns by %.3g deg/s; begin and end where it rests",
                     end == &parts.front() ? stated.begin_s : stated.end_s, rate * kDegPerRad);
  // A rate that leans by a small angle to either side of the mean axis turns by less than its length, by half the
  // square of that angle.
  const double lost_rad = 0.5 * c.across * c.across * stated.angle_rad;
  if (lost_rad > stated.sd_rad)
    return refused(
        "the axis moves in the body: %.0f %% of the rate (rms) are across it, so up to %.3g deg are not in the "
        "angle; turn it on a flat support or about an edge, or state a larger deviation",
        100.0 * c.across, lost_rad * kDegPerRad);
  // Where it turns at its ends, either may be half a step off.
  const double edges_rad = stated.steady ? step_s * read_rad / duration_s : 0.0;
  turn.angle_rad = stated.angle_rad;
  turn.variance_rad2 = squared(stated.sd_rad) + squared(lost_rad) + squared(edges_rad) / 6.0 +
                       squared(kGyroNonlinearity * stated.angle_rad) + squared(kGyroWhite_radps_rtHz) * duration_s;
  turn.integral_of_bias = squared(duration_s) * bias_covariance;
  return turn;
}

}  // namespace stillpoint::calib

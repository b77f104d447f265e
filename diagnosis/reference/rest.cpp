#include "diagnosis/reference/rest.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stillpoint::diag {
namespace {

constexpr double kRestWindow_s = 0.6;
constexpr double kRestMargin_s = 0.25;

/// Standard deviation of the three axes together in a window around each sample.
Series local_deviation(const Series3& x, Eigen::Index half) {
  Series variance = Series::Zero(x.rows());
  for (int a = 0; a < 3; ++a) {
    const Series centred = x.col(a).array() - x.col(a).mean();
    const Series mean = moving_mean(centred, half);
    variance += (moving_mean(centred.cwiseAbs2(), half) - mean.cwiseAbs2()).cwiseMax(0.0);
  }
  return (variance / 3.0).cwiseSqrt();
}

/// Each rest that is none is no longer one: none(begin, end).
template <class IsNone>
void wake(Mask& rest, const IsNone& none) {
  each_run(
      static_cast<Eigen::Index>(rest.size()), [&](Eigen::Index i) { return rest[static_cast<std::size_t>(i)] != 0; },
      [&](Eigen::Index begin, Eigen::Index end) {
        if (none(begin, end)) std::fill(rest.begin() + begin, rest.begin() + end, std::uint8_t{0});
      });
}

using Rows = Eigen::Array<bool, Eigen::Dynamic, 1>;

/// As quiet as the sensor ever is, or as its noise lets it be.
Rows quiet_rows(const Signals& s, Sensor sensor) {
  const Series deviation = local_deviation(s.reading[sensor], static_cast<Eigen::Index>(0.5 * kRestWindow_s / s.dt_s));
  const double floor = std::max(quantile(deviation, 0.1), 0.7 * s.noise_sd[sensor]);
  return deviation.array() < 2.0 * floor;
}

/// Stretches of `still` without their edges, added to `rest`.
void add_rests(const Rows& still, Eigen::Index margin, Mask& rest) {
  const Eigen::Index n = still.size();
  each_run(
      n, [&](Eigen::Index i) { return still[i]; },
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index k = begin == 0 ? 0 : begin + margin; k < (end == n ? end : end - margin); ++k)
          rest[static_cast<std::size_t>(k)] = 1;
      });
}

/// A vector's mean over windows: what a camera's noise leaves in it is little.
Series3 steady(const Series3& x, Eigen::Index half) {
  Series3 out(x.rows(), 3);
  for (int axis = 0; axis < 3; ++axis) out.col(axis) = moving_mean(x.col(axis), half);
  return out;
}

Series steady_square(const Series3& x, Eigen::Index half) { return steady(x, half).rowwise().squaredNorm(); }

}  // namespace

Mask find_rest(const Signals& s) {
  Mask rest(static_cast<std::size_t>(s.n), 0);
  if (!s.present[kAcc] && !s.present[kGyr]) return rest;
  Rows quiet = Rows::Constant(s.n, true);
  for (const Sensor sensor : {kAcc, kGyr})
    if (s.present[sensor]) quiet = quiet && quiet_rows(s, sensor);
  if (s.present[kGyr]) quiet = quiet && s.reading[kGyr].rowwise().norm().array() < 0.15;
  add_rests(quiet, static_cast<Eigen::Index>(kRestMargin_s / s.dt_s), rest);
  return rest;
}

void rest_where_reference_is_still(Mask& rest, const Signals& s, const Series3& rate_radps, const Series3& velocity_mps,
                                   bool exact) {
  constexpr double kWindow_s = 2.0;
  const double still_radps = exact ? 1e-3 : 3e-3, still_mps = exact ? 1e-3 : 3e-3;
  if (!s.present[kAcc] || velocity_mps.rows() != s.n) return;
  const auto half = static_cast<Eigen::Index>(0.5 * kWindow_s / s.dt_s);
  const Rows still = quiet_rows(s, kAcc) && steady_square(rate_radps, half).array() < still_radps * still_radps &&
                     steady_square(velocity_mps, half).array() < still_mps * still_mps;
  add_rests(still, half, rest);
}

void wake_where_reference_moves(Mask& rest, const Series3& rate_radps, const Series3& velocity_mps, double dt_s,
                                bool exact) {
  const Eigen::Index n = rate_radps.rows();
  const double still_radps = exact ? 5e-3 : 3e-2, still_mps = exact ? 5e-3 : 2e-2;  // a camera has noise
  const auto half = static_cast<Eigen::Index>(0.5 * kRestWindow_s / dt_s);
  const Series turning = steady_square(rate_radps, half);
  const Series going = velocity_mps.rows() == n ? steady_square(velocity_mps, half) : Series::Zero(n);
  const auto typical = [](const Series& x, Eigen::Index begin, Eigen::Index end) {
    return std::sqrt(quantile(x.segment(begin, end - begin), 0.5));
  };
  wake(rest, [&](Eigen::Index begin, Eigen::Index end) {
    return typical(turning, begin, end) >= still_radps || typical(going, begin, end) >= still_mps;
  });
  // A car that brakes and stands: as quiet all along, at rest in the end. A single frame that is wrong is no motion.
  constexpr double kMoves_s = 0.5;
  const auto moves = [&](Eigen::Index i) {
    return rest[static_cast<std::size_t>(i)] &&
           (turning[i] >= still_radps * still_radps || going[i] >= still_mps * still_mps);
  };
  each_run(n, moves, [&](Eigen::Index begin, Eigen::Index end) {
    if (static_cast<double>(end - begin) * dt_s < kMoves_s) return;
    for (Eigen::Index i = std::max<Eigen::Index>(0, begin - half); i < std::min(n, end + half); ++i)
      rest[static_cast<std::size_t>(i)] = 0;
  });
}

void wake_where_both_move(Mask& rest, const Signals& s, const Series3& rate_radps) {
  constexpr double kMost = 0.5, kSure = 3.0;  // of the lesser power of the two; deviations of the gyroscope's noise
  constexpr double kMean_s = 0.3;             // a camera's noise is faster than who sways
  if (!s.present[kGyr]) return;
  const auto half = static_cast<Eigen::Index>(0.5 * kMean_s / s.dt_s);
  const Series3 slow_rate = steady(rate_radps, half), slow_reading = steady(s.reading[kGyr], half);
  wake(rest, [&](Eigen::Index begin, Eigen::Index end) {
    const auto seen = slow_rate.middleRows(begin, end - begin);
    const auto read = slow_reading.middleRows(begin, end - begin);
    const Series3 swings = read.rowwise() - read.colwise().mean();
    const double most = std::min(seen.squaredNorm(), swings.squaredNorm());
    return swings.cwiseProduct(seen).sum() > kMost * most + kSure * s.noise_sd[kGyr] * seen.norm();
  });
}

void wake_where_both_turn(Mask& rest, const Signals& s, const Series3& rate_radps, double noise_rad) {
  constexpr double kSure = 5.0, kAgree = 0.5;  // deviations of a turn between two frames; of the turn
  if (!s.present[kGyr]) return;
  std::vector<Eigen::Index> resting;
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (rest[static_cast<std::size_t>(i)]) resting.push_back(i);
  if (resting.empty()) return;
  Eigen::RowVector3d typical;
  for (int axis = 0; axis < 3; ++axis) typical[axis] = quantile(Series(s.reading[kGyr](resting, axis)), 0.5);
  wake(rest, [&](Eigen::Index begin, Eigen::Index end) {
    const Eigen::RowVector3d seen = rate_radps.middleRows(begin, end - begin).colwise().mean();
    const Eigen::RowVector3d turns = s.reading[kGyr].middleRows(begin, end - begin).colwise().mean();
    const double least = kSure * std::sqrt(2.0) * noise_rad / (static_cast<double>(end - begin) * s.dt_s);
    const double off = std::min((seen - turns).norm(), (seen - turns + typical).norm());
    return seen.norm() > least && off < kAgree * seen.norm();
  });
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/rest.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

Mask find_rest(const Signals& s) {
  const auto half = static_cast<Eigen::Index>(0.5 * kRestWindow_s / s.dt_s);
  Eigen::Array<bool, Eigen::Dynamic, 1> quiet = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(s.n, true);
  bool any = false;
  for (const Sensor sensor : {kAcc, kGyr}) {
    if (!s.present[sensor]) continue;
    const Series deviation = local_deviation(s.reading[sensor], half);
    const double floor = std::max(quantile(deviation, 0.1), 0.7 * s.noise_sd[sensor]);
    quiet = quiet && deviation.array() < 2.0 * floor;
    any = true;
  }
  if (s.present[kGyr]) quiet = quiet && s.reading[kGyr].rowwise().norm().array() < 0.15;
  Mask rest(static_cast<std::size_t>(s.n), 0);
  const auto margin = static_cast<Eigen::Index>(kRestMargin_s / s.dt_s);
  Eigen::Index begin = 0;
  for (Eigen::Index i = 0; any && i <= s.n; ++i) {
    if (i < s.n && quiet[i]) continue;
    for (Eigen::Index k = begin == 0 ? 0 : begin + margin; k < (i == s.n ? i : i - margin); ++k)
      rest[static_cast<std::size_t>(k)] = 1;
    begin = i + 1;
  }
  return rest;
}

void wake_where_reference_moves(Mask& rest, const Series3& rate_radps, const Series3& velocity_mps, double dt_s,
                                bool exact) {
  const Eigen::Index n = rate_radps.rows();
  const double still_radps = exact ? 5e-3 : 3e-2, still_mps = exact ? 5e-3 : 2e-2;  // a camera has noise
  const auto half = static_cast<Eigen::Index>(0.5 * kRestWindow_s / dt_s);
  Series turning = Series::Zero(n), going = Series::Zero(n);
  for (int axis = 0; axis < 3; ++axis) {
    turning += moving_mean(rate_radps.col(axis), half).cwiseAbs2();
    if (velocity_mps.rows() == n) going += moving_mean(velocity_mps.col(axis), half).cwiseAbs2();
  }
  const auto typical = [](const Series& x, Eigen::Index begin, Eigen::Index end) {
    return std::sqrt(quantile(x.segment(begin, end - begin), 0.5));
  };
  for (Eigen::Index begin = 0, end = 0; begin < n; begin = end + 1) {
    for (end = begin; end < n && rest[static_cast<std::size_t>(end)];) ++end;
    if (end == begin || (typical(turning, begin, end) < still_radps && typical(going, begin, end) < still_mps))
      continue;
    std::fill(rest.begin() + begin, rest.begin() + end, std::uint8_t{0});
  }
}

}  // namespace stillpoint::diag

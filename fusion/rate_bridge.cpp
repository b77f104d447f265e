#include "fusion/rate_bridge.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {
namespace {

/// A motion comes up within half a second and is remembered for ten.
constexpr double kRise_s = 0.5, kMemory_s = 10.0;
/// A body that lay still may have been taken up meanwhile: turned at this rate, another one after this time.
constexpr double kLeastRate_radps = 0.3, kLeastTime_s = 0.2;

/// The walk is judged by a handful of changes, and a pause may fall on just what they do not show.
constexpr double kUnsure = 3.0;

double share(bool rises, double time_s) { return std::min(1.0, time_s / (rises ? kRise_s : kMemory_s)); }

/// Variance of the turn about one axis [rad^2]. A random walk pinned at both ends encloses an area of variance
/// q T^3 / 12; over many correlation times 2 s^2 / q the ends say nothing any more, and it is 2 s^2 t T.
double bridge(double rate2, double walk, double gap_s) {
  const double pinned = walk * gap_s * gap_s * gap_s / 12.0;
  const double free = 4.0 * rate2 * rate2 / walk * gap_s;
  return pinned * free / (pinned + free);
}

}  // namespace

void RateBridge::observe(const Vec3& rate_radps, double time_s) noexcept {
  const double rate2 = rate_radps.squaredNorm();
  rate2_ += share(rate2 > rate2_, time_s) * (rate2 - rate2_);
  if (filled_ == kLag) {
    const Vec3 change = rate_radps - vec(rates_radps_[at_]);
    const Mat3 now = change * change.transpose() / (kLag * time_s);
    auto walk = mat(walk_);
    walk += share(now.trace() > walk.trace(), time_s) * (now - walk);
  }
  vec(rates_radps_[at_]) = rate_radps;
  at_ = (at_ + 1) % kLag;
  filled_ = std::min(filled_ + 1, kLag);
}

void RateBridge::note_step(double step_s) noexcept {
  // A running median: single pauses hardly count.
  if (usual_step_s_ == 0.0)
    usual_step_s_ = step_s;
  else
    usual_step_s_ *= step_s > usual_step_s_ ? 1.02 : 1.0 / 1.02;
}

Mat3 RateBridge::bridge_rad2(double gap_s) const noexcept {
  constexpr double kLeast2 = kLeastRate_radps * kLeastRate_radps;
  const double any = bridge(kLeast2, 2.0 * kLeast2 / kLeastTime_s, gap_s);
  const auto walk = mat(walk_);
  const double total = walk.trace();
  Mat3 turn = any * Mat3::Identity();
  if (total > 0.0) turn += walk * (bridge(rate2_, total, gap_s) / total);
  return kUnsure * turn;
}

}  // namespace stillpoint::fusion

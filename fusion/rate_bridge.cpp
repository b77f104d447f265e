#include "fusion/rate_bridge.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {
namespace {

/// A motion comes up within half a second and is remembered for ten.
constexpr double kRise_s = 0.5, kMemory_s = 10.0;
/// A body that lay still may have been taken up meanwhile: turned at this rate, another one after this time.
constexpr double kLeastRate_radps = 0.3, kLeastTime_s = 0.2;

double follow(double mean, double now, double time_s) {
  return mean + std::min(1.0, time_s / (now > mean ? kRise_s : kMemory_s)) * (now - mean);
}

}  // namespace

void RateBridge::observe(const Vec3& rate_radps, double time_s) noexcept {
  rate2_ = follow(rate2_, rate_radps.squaredNorm() / 3.0, time_s);
  if (filled_ == kLag) {
    const double change2 = (rate_radps - vec(rates_radps_[at_])).squaredNorm() / 3.0;
    walk_ = follow(walk_, change2 / (kLag * time_s), time_s);
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

double RateBridge::bridge_rad2(double gap_s) const noexcept {
  const double least2 = kLeastRate_radps * kLeastRate_radps;
  const double rate2 = std::max(rate2_, least2);
  const double walk = std::max(walk_, 2.0 * least2 / kLeastTime_s);
  // A random walk pinned at both ends encloses an area of variance q T^3 / 12; over many correlation times 2 s^2 / q
  // the ends say nothing any more, and it is 2 s^2 t T.
  const double pinned = walk * gap_s * gap_s * gap_s / 12.0;
  const double free = 4.0 * rate2 * rate2 / walk * gap_s;
  return pinned * free / (pinned + free);
}

}  // namespace stillpoint::fusion

/// What one triad's readings have been like: for how long they repeat themselves, how large they are.
#include <algorithm>
#include <cmath>

#include "pipeline/health_monitor.h"

namespace stillpoint::pipeline {
namespace {

constexpr double kLongerThanEver = 5.0;  ///< a coarse sensor repeats itself at rest: it has before
constexpr double kAlive = 0.5, kAlive_s = 5.0;

}  // namespace

void HealthMonitor::FadingMean::add(double x, double dt_s, double longest_s) noexcept {
  over_s = std::min(over_s + dt_s, longest_s);
  if (over_s > 0.0) value += dt_s / over_s * (x - value);
}

void HealthMonitor::Readings::note(const Array3& reading, bool clipped_now, double dt_s) noexcept {
  const bool same = heard && reading == last;
  if (!same) longest_same_s = std::max(longest_same_s, same_s);
  same_s = same ? same_s + dt_s : 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    Axis& a = axes[k];
    if (heard && reading[k] == last[k]) {
      a.same_s += dt_s;
      for (const std::size_t j : {(k + 1) % 3, (k + 2) % 3})
        a.others_moved = std::max(a.others_moved, std::abs(reading[j] - a.others[j]));
    } else {
      const double silent_s = std::min(a.same_s, kAlive_s);
      a.alive += (dt_s * (1.0 - a.alive) - silent_s * a.alive) / kAlive_s;
      a = {0.0, std::clamp(a.alive, 0.0, 1.0), reading, 0.0};
    }
  }
  zero_s = vec(reading).isZero(0.0) ? zero_s + dt_s : 0.0;
  norm.add(vec(reading).norm(), dt_s, kMean_s);
  norm_now.add(vec(reading).norm(), dt_s, kNow_s);
  clipped += std::min(1.0, dt_s) * ((clipped_now ? 1.0 : 0.0) - clipped);
  last = reading;
  heard = true;
}

/// How long one axis has repeated itself while the others moved by so much; 0: none has.
double HealthMonitor::Readings::stuck_axis_s(double moved) const noexcept {
  double longest_s = 0.0;
  for (const Axis& a : axes)
    if (a.alive > kAlive && a.others_moved > moved) longest_s = std::max(longest_s, a.same_s);
  return longest_s;
}

/// All three repeat themselves for longer than this sensor ever did.
bool HealthMonitor::Readings::hung() const noexcept {
  return heard && norm.over_s >= kMean_s && same_s > kStuck_s && same_s > kLongerThanEver * longest_same_s;
}

}  // namespace stillpoint::pipeline

#include "fusion/moving_start.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "fusion/attitude_storage.h"
#include "fusion/attitude_unknown.h"

namespace stillpoint::fusion {
namespace {

constexpr double kLook_s = 1.0;         ///< a start that has been calm for so long was none in motion
constexpr double kStrong_mps2 = 1.5;    ///< deviation of the force, per axis: no hand that is held still
constexpr double kFor_s = 3.0;          ///< two strides and more
constexpr double kUnseenTime_s = 0.25;  ///< of a motion of which not even one swing has been seen
constexpr double kUnseenSpeed_mps = 2.5;

}  // namespace

Vec3 MovingStart::force_mps2() const noexcept { return vec(velocity_mps_) / time_s_; }

double MovingStart::speed2_m2ps2() const noexcept {
  // Of the velocity that remains beside the straight line: V(t) - m t.
  const Vec3 m = force_mps2();
  const Vec3 mean = vec(path_m_) / time_s_ - 0.5 * time_s_ * m;
  const double square =
      (velocity2_ - 2.0 * m.dot(vec(moment_ms_)) + m.squaredNorm() * time_s_ * time_s_ * time_s_ / 3.0) / time_s_;
  return 0.5 * std::max(0.0, square - mean.squaredNorm());  // as if all of it were level
}

double MovingStart::tilt_sd_rad() const noexcept {
  const double over_s = kStandardGravity_mps2 * time_s_;
  const double seen = 2.0 * speed2_m2ps2() / (over_s * over_s);
  const double unseen = kUnseenSpeed_mps / (kStandardGravity_mps2 * (time_s_ + kUnseenTime_s));
  return std::min(1.0, std::sqrt(kStartTilt_rad * kStartTilt_rad + seen + unseen * unseen));
}

void MovingStart::turn_world(const Mat3& R) noexcept {
  for (Array3* x : {&velocity_mps_, &path_m_, &moment_ms_}) vec(*x) = R * vec(*x);
}

void MovingStart::observe(const Vec3& force_mps2, double period_s) noexcept {
  if (over_) return;
  const Vec3 before = vec(velocity_mps_);
  vec(velocity_mps_) += force_mps2 * period_s;
  const Vec3 middle = 0.5 * (before + vec(velocity_mps_));
  vec(path_m_) += middle * period_s;
  vec(moment_ms_) += middle * (time_s_ + 0.5 * period_s) * period_s;
  velocity2_ += middle.squaredNorm() * period_s;
  force2_ += force_mps2.squaredNorm() * period_s;
  time_s_ += period_s;
  const double scatter2 = (force2_ / time_s_ - this->force_mps2().squaredNorm()) / 3.0;
  moving_ |= scatter2 > kStrong_mps2 * kStrong_mps2;
  over_ = time_s_ > (moving_ ? kFor_s : kLook_s);
}

}  // namespace stillpoint::fusion

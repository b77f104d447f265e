/// How the filter keeps and reads its quaternion. Internal to fusion.
#pragma once
#include <cmath>
#include <numbers>

#include "core/so3.h"
#include "fusion/attitude_estimate.h"

namespace stillpoint::fusion {

inline double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// Angle of the turn about the vertical, counter-clockwise from east. Defined at every tilt but upside down.
inline double heading_of(const Quat& q) { return wrapped(2.0 * std::atan2(q.z(), q.w())); }

/// Horizontal unit vector of that heading, by the formulas of the double angle: no trigonometry at every sample.
inline Vec3 direction_of_heading(const Quat& q) {
  const double w2 = q.w() * q.w(), z2 = q.z() * q.z();
  if (!(w2 + z2 > 0.0)) return Vec3::UnitX();
  return Vec3((w2 - z2) / (w2 + z2), 2.0 * q.w() * q.z() / (w2 + z2), 0.0);
}

}  // namespace stillpoint::fusion

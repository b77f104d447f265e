/// Rotations: exponential and logarithm of SO(3), its right Jacobian, and the small helpers around them.
/// After Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", eqs. (132)-(144).
#pragma once
#include <cmath>

#include "core/types.h"

namespace stillpoint {

/// [v]x, so that skew(v) * w = v x w.
inline Mat3 skew(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Rotation by the vector phi (rad). Below 1e-4 rad the series to second order is exact to 1e-16.
inline Quat exp_quat(const Vec3& phi) {
  const double angle = phi.norm();
  const double half_sinc = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  const double w = std::cos(0.5 * angle);
  return Quat(w, half_sinc * phi.x(), half_sinc * phi.y(), half_sinc * phi.z());
}

inline Mat3 exp_so3(const Vec3& phi) { return exp_quat(phi).toRotationMatrix(); }

/// Rotation vector (rad) of q, of length at most pi; q and -q give the same.
inline Vec3 log_quat(const Quat& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double sin_half = q.vec().norm();
  // Near zero: angle / sin(angle/2) = 2 (1 + s^2/6 + ...) with s = sin(angle/2).
  const double scale =
      sin_half < 1e-4 ? 2.0 * (1.0 + sin_half * sin_half / 6.0) : 2.0 * std::atan2(sin_half, sign * q.w()) / sin_half;
  return sign * scale * q.vec();
}

inline Vec3 log_so3(const Mat3& R) { return log_quat(Quat(R)); }

/// Jr(phi): exp(phi + d) = exp(phi) exp(Jr d) to first order. Below 1e-4 rad the series to second order.
inline Mat3 right_jacobian(const Vec3& phi) {
  const double a2 = phi.squaredNorm();
  const double a = std::sqrt(a2);
  const Mat3 K = skew(phi);
  const double b = a < 1e-4 ? 0.5 - a2 / 24.0 : (1.0 - std::cos(a)) / a2;
  const double c = a < 1e-4 ? 1.0 / 6.0 - a2 / 120.0 : (a - std::sin(a)) / (a2 * a);
  return Mat3::Identity() - b * K + c * K * K;
}

}  // namespace stillpoint

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

/// What the functions below are made of, as series in the square of an angle a: exact to the last bit below 0.1 rad,
/// more than a body turns in a sample. There they cost less than the quotients, which lose digits to cancellation.
namespace so3_series {
constexpr double kBelow_rad2 = 0.01;
/// sin a / a
inline double sinc(double a2) noexcept {
  return 1.0 + a2 * (-1.0 / 6.0 + a2 * (1.0 / 120.0 + a2 * (-1.0 / 5040.0 + a2 * (1.0 / 362880.0))));
}
/// (1 - cos a) / a^2
inline double cosc(double a2) noexcept {
  return 0.5 + a2 * (-1.0 / 24.0 + a2 * (1.0 / 720.0 + a2 * (-1.0 / 40320.0 + a2 * (1.0 / 3628800.0))));
}
/// (a - sin a) / a^3
inline double sinc_remainder(double a2) noexcept {
  return 1.0 / 6.0 + a2 * (-1.0 / 120.0 + a2 * (1.0 / 5040.0 + a2 * (-1.0 / 362880.0 + a2 * (1.0 / 39916800.0))));
}
/// atan(t) / t, t the tangent of half an angle
inline double atan_quotient(double t2) noexcept {
  return 1.0 + t2 * (-1.0 / 3.0 + t2 * (1.0 / 5.0 + t2 * (-1.0 / 7.0 + t2 * (1.0 / 9.0 - t2 * (1.0 / 11.0)))));
}
}  // namespace so3_series

/// Rotation by the vector phi (rad).
inline Quat exp_quat(const Vec3& phi) {
  const double half2 = 0.25 * phi.squaredNorm();
  const auto quaternion = [&phi](double w, double half_sinc) {
    return Quat(w, half_sinc * phi.x(), half_sinc * phi.y(), half_sinc * phi.z());
  };
  if (half2 < so3_series::kBelow_rad2)
    return quaternion(1.0 - half2 * so3_series::cosc(half2), 0.5 * so3_series::sinc(half2));
  const double half = std::sqrt(half2);
  return quaternion(std::cos(half), 0.5 * std::sin(half) / half);
}

/// The product of unit quaternions, brought back to unit norm: it is off by rounding alone, so one Newton step serves.
inline Quat renormalized(const Quat& q) { return Quat((1.5 - 0.5 * q.squaredNorm()) * q.coeffs()); }

/// Of a product of unit quaternions: unit norm and w >= 0, so that the same attitude has the same four numbers.
inline Array4 array(const Quat& q) {
  const Quat n = renormalized(q);
  const double sign = n.w() < 0 ? -1.0 : 1.0;
  return {sign * n.w(), sign * n.x(), sign * n.y(), sign * n.z()};
}

inline Mat3 exp_so3(const Vec3& phi) { return exp_quat(phi).toRotationMatrix(); }

/// Rotation vector (rad) of q, of length at most pi; q and -q give the same.
inline Vec3 log_quat(const Quat& q) {
  const double sin2 = q.vec().squaredNorm(), cos2 = q.w() * q.w();
  if (sin2 < 0.25 * so3_series::kBelow_rad2 * cos2)
    return 2.0 / q.w() * so3_series::atan_quotient(sin2 / cos2) * q.vec();
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const double sin_half = std::sqrt(sin2);
  return sign * 2.0 * std::atan2(sin_half, sign * q.w()) / sin_half * q.vec();
}

inline Vec3 log_so3(const Mat3& R) { return log_quat(Quat(R)); }

/// Jr(phi): exp(phi + d) = exp(phi) exp(Jr d) to first order.
inline Mat3 right_jacobian(const Vec3& phi) {
  const double a2 = phi.squaredNorm();
  double cosc = so3_series::cosc(a2), remainder = so3_series::sinc_remainder(a2);
  if (!(a2 < so3_series::kBelow_rad2)) {
    const double a = std::sqrt(a2);
    cosc = (1.0 - std::cos(a)) / a2;
    remainder = (a - std::sin(a)) / (a2 * a);
  }
  // I - cosc [phi]x + remainder [phi]x^2, of which the square is phi phi' - |phi|^2 I.
  Mat3 Jr = remainder * phi * phi.transpose() - skew(cosc * phi);
  Jr.diagonal().array() += 1.0 - remainder * a2;
  return Jr;
}

}  // namespace stillpoint

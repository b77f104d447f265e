/// A function of time known with its first two derivatives. Motions are written once, as the path itself; sums,
/// products and sines of these triples then give velocity, acceleration, body rate and angular acceleration exactly, so
/// that no derivative can disagree with the path it belongs to. After Griewank, Walther, "Evaluating Derivatives", 2nd
/// ed., ch. 13 (Taylor arithmetic).
#pragma once
#include <array>
#include <cmath>

#include "core/types.h"

namespace stillpoint::sim {

struct Taylor {
  double x = 0.0, d = 0.0, dd = 0.0;  ///< value, d/dt, d2/dt2

  static constexpr Taylor time(double t_s) { return {t_s, 1.0, 0.0}; }
};

constexpr Taylor operator+(const Taylor& a, const Taylor& b) { return {a.x + b.x, a.d + b.d, a.dd + b.dd}; }
constexpr Taylor operator-(const Taylor& a, const Taylor& b) { return {a.x - b.x, a.d - b.d, a.dd - b.dd}; }
constexpr Taylor operator-(const Taylor& a) { return {-a.x, -a.d, -a.dd}; }
constexpr Taylor operator+(const Taylor& a, double b) { return {a.x + b, a.d, a.dd}; }
constexpr Taylor operator-(const Taylor& a, double b) { return {a.x - b, a.d, a.dd}; }
constexpr Taylor operator*(double k, const Taylor& a) { return {k * a.x, k * a.d, k * a.dd}; }
constexpr Taylor operator*(const Taylor& a, const Taylor& b) {
  return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2.0 * a.d * b.d + a.x * b.dd};
}
/// g(a) for a function with value g, slope dg and curvature ddg at a.x.
constexpr Taylor chain(const Taylor& a, double g, double dg, double ddg) {
  return {g, dg * a.d, ddg * a.d * a.d + dg * a.dd};
}
inline Taylor sin(const Taylor& a) {
  const double s = std::sin(a.x), c = std::cos(a.x);
  return chain(a, s, c, -s);
}
inline Taylor cos(const Taylor& a) {
  const double s = std::sin(a.x), c = std::cos(a.x);
  return chain(a, c, -s, -c);
}
inline Taylor exp(const Taylor& a) {
  const double e = std::exp(a.x);
  return chain(a, e, e, e);
}
inline Taylor rsqrt(const Taylor& a) {
  const double r = 1.0 / std::sqrt(a.x);
  return chain(a, r, -0.5 * r / a.x, 0.75 * r / (a.x * a.x));
}

/// From 0 to 1 while u goes from 0 to 1, with three vanishing derivatives at both ends: rest joins motion without a
/// step in acceleration or angular acceleration.
constexpr Taylor smooth_step(const Taylor& u) {
  if (u.x <= 0.0) return {};
  if (u.x >= 1.0) return {1.0, 0.0, 0.0};
  const double v = u.x, w = 1.0 - v;
  return chain(u, v * v * v * v * (35.0 + v * (-84.0 + v * (70.0 - 20.0 * v))), 140.0 * v * v * v * w * w * w,
               420.0 * v * v * w * w * (1.0 - 2.0 * v));
}

struct TaylorVec {
  std::array<Taylor, 3> at{};

  TaylorVec& add(const Vec3& direction, const Taylor& amount) {
    for (std::size_t i = 0; i < 3; ++i) at[i] = at[i] + direction[static_cast<Eigen::Index>(i)] * amount;
    return *this;
  }
};

struct TaylorQuat {
  Taylor w{1.0, 0.0, 0.0}, x, y, z;
};

inline TaylorQuat constant(const Quat& q) { return {{q.w(), 0, 0}, {q.x(), 0, 0}, {q.y(), 0, 0}, {q.z(), 0, 0}}; }

constexpr TaylorQuat operator*(const TaylorQuat& a, const TaylorQuat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// Rotation by the vector phi(t), rad. With s = |phi|^2 and a = sqrt(s): w = c(s) = cos(a/2), vector part h(s) phi with
/// h = sin(a/2)/a; c' = -h/4, h' = (c/2 - h)/(2s), h'' = (-h/8 - 3h')/(2s). Below s = 0.02 the series to s^4 of h is
/// exact to 1e-15 and its second derivative to 2e-15; above, cancellation costs h'' at most 1e-12.
inline TaylorQuat exp_quat(const TaylorVec& phi) {
  const Taylor s = phi.at[0] * phi.at[0] + phi.at[1] * phi.at[1] + phi.at[2] * phi.at[2];
  const double a = std::sqrt(s.x);
  const double c = std::cos(0.5 * a);
  double h, dh, ddh;
  if (s.x < 0.02) {
    h = 0.5 + s.x * (-1.0 / 48 + s.x * (1.0 / 3840 + s.x * (-1.0 / 645120 + s.x / 185794560)));
    dh = -1.0 / 48 + s.x * (1.0 / 1920 + s.x * (-1.0 / 215040 + s.x / 46448640));
    ddh = 1.0 / 1920 + s.x * (-1.0 / 107520 + s.x / 15482880);
  } else {
    h = std::sin(0.5 * a) / a;
    dh = (0.5 * c - h) / (2.0 * s.x);
    ddh = (-0.125 * h - 3.0 * dh) / (2.0 * s.x);
  }
  const Taylor scale = chain(s, h, dh, ddh);
  return {chain(s, c, -0.25 * h, -0.25 * dh), scale * phi.at[0], scale * phi.at[1], scale * phi.at[2]};
}

}  // namespace stillpoint::sim

#include "diagnosis/reference/columns.h"

#include <cmath>

#include "core/cross_rows.h"
#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {

Columns on_each_axis(const Series& x) { return {{0, x}, {1, x}, {2, x}}; }

Columns diagonal(const Series3& x) { return {{0, x.col(0)}, {1, x.col(1)}, {2, x.col(2)}}; }

Columns matrix_of(const Series3& x) {
  Columns out;
  for (int row = 0; row < 3; ++row)
    for (int c = 0; c < 3; ++c) out.push_back({row, x.col(c)});
  return out;
}

std::vector<std::string> entries(const std::string& letter) {
  std::vector<std::string> names;
  for (const char* row : kAxisName)
    for (const char* column : kAxisName) names.push_back(letter + "_" + row + column);
  return names;
}

Columns coupled(std::initializer_list<Series3> parts) {
  Columns out;
  for (const auto& part : parts) out.push_back({-1, part});
  return out;
}

Columns world_fixed(const Signals& s) { return coupled({s.world_axis[0], s.world_axis[1], s.world_axis[2]}); }

Series integral(const Series& rate, double dt_s) {
  Series out = Series::Zero(rate.size());
  for (Eigen::Index i = 1; i < rate.size(); ++i) out[i] = out[i - 1] + rate[i - 1] * dt_s;
  return out;
}

Series lagged_difference(const Series& T, double dt_s, double tau_s) {
  Series out(T.size());
  double lagged = T.size() ? T[0] : 0.0;
  const double share = 1.0 - std::exp(-dt_s / tau_s);
  for (Eigen::Index i = 0; i < T.size(); ++i) {
    lagged += share * (T[i] - lagged);
    out[i] = T[i] - lagged;
  }
  return out;
}

Series after_tracker(const Series& x, const Mask& rest, double dt_s, double tau_s) {
  Series out(x.size());
  double tracked = 0.0;
  const double share = 1.0 - std::exp(-dt_s / tau_s);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (rest[static_cast<std::size_t>(i)]) tracked += share * (x[i] - tracked);
    out[i] = x[i] - tracked;
  }
  return out;
}

Series3 lever_column(const Signals& s, int j) {
  Series3 out(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    const Vec3 w = s.rate.row(i), a = s.rate_dot.row(i), e = Vec3::Unit(j);
    out.row(i) = a.cross(e) + w.cross(w.cross(e));
  }
  return out;
}

Columns size_columns(const Signals& s) {
  Columns out;
  const std::array<Series3, 3> lever{lever_column(s, 0), lever_column(s, 1), lever_column(s, 2)};
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& column : lever) out.push_back({axis, column.col(axis)});
  return out;
}

Columns linear_in_place(const Signals& s) {
  Columns out;
  for (int row = 0; row < 3; ++row)
    for (int c = 0; c < 3; ++c)
      out.push_back({-1, s.position_m.col(c).asDiagonal() * s.world_axis[static_cast<std::size_t>(row)]});
  return out;
}

Columns gradient_columns(const Signals& s) {
  Columns out;
  for (int j = 0; j < 5; ++j) {
    const Series3 in_the_world = s.position_m * gradient_of(Eigen::VectorXd::Unit(5, j));
    out.push_back({-1, in_body(s, in_the_world)});
  }
  return joined(std::move(out), world_fixed(s));
}

Mat3 gradient_of(const Eigen::Ref<const Eigen::VectorXd>& five) {
  Mat3 G;
  G << five[0], five[1], five[2], five[1], five[3], five[4], five[2], five[4], -five[0] - five[3];
  return G;
}

Series3 at_rest_zero(const Signals& s, Series3 x) {
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (s.rest[static_cast<std::size_t>(i)]) x.row(i).setZero();
  return x;
}

Columns turned_columns(const Signals& s) {
  const auto about = [&s](std::size_t axis) { return cross_rows(s.world_axis[axis], s.vector[kAcc]); };
  return coupled({about(0), about(1), about(2)});
}

Columns smoothing_columns(const Signals& s, Sensor sensor, bool places) {
  if (sensor == kGyr) return coupled({-derivative(s.rate_dot, s.rows) - cross_rows(s.rate, s.rate_dot)});
  Series3 out = cross_rows(s.rate_dot, s.vector[sensor]);
  if (places) out -= at_rest_zero(s, in_body(s, second_derivative(in_world(s, s.vector[kAcc]), s.rows)));
  return coupled({out});
}

}  // namespace stillpoint::diag

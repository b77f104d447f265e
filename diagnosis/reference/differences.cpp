#include "diagnosis/reference/differences.h"

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace stillpoint::diag {
namespace {

using Weights = std::array<double, kStencilReach>;

constexpr double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

/// Weights of the differences over m neighbours, order 2 m (Fornberg, "Generation of Finite Difference Formulas on
/// Arbitrarily Spaced Grids", 1988, table 1): +-(m!)^2 / ((m - k)! (m + k)!) over k for the first derivative, over
/// k^2 / 2 for the second.
Weights weights(int derivative, int m) {
  Weights c{};
  for (int k = 1; k <= m; ++k)
    c[static_cast<std::size_t>(k - 1)] = (k % 2 == 0 ? -1.0 : 1.0) * factorial(m) * factorial(m) /
                                         (factorial(m - k) * factorial(m + k)) / (derivative == 1 ? k : 0.5 * k * k);
  return c;
}

Weights minus(Weights a, const Weights& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return a;
}

Series3 with_ends(Series3 d) {
  const Eigen::Index n = d.rows();
  d.topRows(kStencilReach).rowwise() = d.row(kStencilReach).eval();
  d.bottomRows(kStencilReach).rowwise() = d.row(n - 1 - kStencilReach).eval();
  return d;
}

/// Sum over k of c_k (x_{i+k} + sign x_{i-k}), and for an even stencil the centre that makes a constant vanish.
Series3 differences(const Series3& x, const Weights& c, double sign) {
  const Eigen::Index reach = kStencilReach, middle = x.rows() - 2 * reach;
  Series3 d = Series3::Zero(x.rows(), 3);
  if (middle < 1) return d;
  if (sign > 0)
    d.middleRows(reach, middle) = -2.0 * std::accumulate(c.begin(), c.end(), 0.0) * x.middleRows(reach, middle);
  for (Eigen::Index k = 1; k <= reach; ++k)
    d.middleRows(reach, middle) +=
        c[static_cast<std::size_t>(k - 1)] * (x.middleRows(reach + k, middle) + sign * x.middleRows(reach - k, middle));
  return with_ends(std::move(d));
}

constexpr int kReach = static_cast<int>(kStencilReach);

/// Polynomial through `reach` uneven rows on either side, and the row itself.
Eigen::RowVector3d stencil(const Series3& x, const RowTimes& rows, Eigen::Index i, int order, Eigen::Index reach) {
  Series nodes(2 * reach + 1);
  for (Eigen::Index k = 0; k < nodes.size(); ++k) nodes[k] = (rows.at(i - reach + k) - rows.at(i)) / rows.step_s;
  return polynomial_weights(nodes, 0.0, order).col(order).transpose() * x.middleRows(i - reach, nodes.size());
}

/// A derivative in units of the step.
Series3 of_order(int order, const Series3& x, const RowTimes& rows) {
  static const std::array<Weights, 2> c{weights(1, kReach), weights(2, kReach)};
  if (rows.even()) return differences(x, c[static_cast<std::size_t>(order - 1)], order == 1 ? -1.0 : 1.0);
  Series3 d = Series3::Zero(x.rows(), 3);
  if (x.rows() <= 2 * kStencilReach) return d;
  for (Eigen::Index i = kStencilReach; i + kStencilReach < x.rows(); ++i)
    d.row(i) = stencil(x, rows, i, order, kStencilReach);
  return with_ends(std::move(d));
}

/// What the next shorter stencil gives differently, in units of the step.
Series error_of_order(int order, const Series3& x, const RowTimes& rows) {
  static const std::array<Weights, 2> c{minus(weights(1, kReach), weights(1, kReach - 1)),
                                        minus(weights(2, kReach), weights(2, kReach - 1))};
  if (rows.even())
    return differences(x, c[static_cast<std::size_t>(order - 1)], order == 1 ? -1.0 : 1.0).rowwise().norm();
  Series3 d = Series3::Zero(x.rows(), 3);
  for (Eigen::Index i = kStencilReach; i + kStencilReach < x.rows(); ++i)
    d.row(i) = stencil(x, rows, i, order, kStencilReach) - stencil(x, rows, i, order, kStencilReach - 1);
  return d.rowwise().norm();
}

}  // namespace

Series3 derivative(const Series3& x, const RowTimes& rows) { return of_order(1, x, rows) / rows.step_s; }

Series3 second_derivative(const Series3& x, const RowTimes& rows) {
  return of_order(2, x, rows) / (rows.step_s * rows.step_s);
}

double noise_of_derivative(double sd, double dt_s) {
  static const Weights c = weights(1, kReach);
  return sd * std::sqrt(2.0 * std::inner_product(c.begin(), c.end(), c.begin(), 0.0)) / dt_s;
}

double noise_of_second_derivative(double sd, double dt_s) {
  static const Weights c = weights(2, kReach);
  const double centre = 2.0 * std::accumulate(c.begin(), c.end(), 0.0);
  return sd * std::sqrt(centre * centre + 2.0 * std::inner_product(c.begin(), c.end(), c.begin(), 0.0)) / (dt_s * dt_s);
}

double gain_of_difference(int order, double frequency_hz, double dt_s) {
  const Weights c = weights(order, kReach);
  const double angle = 2.0 * std::numbers::pi * frequency_hz * dt_s;
  double sum = 0.0;
  for (int k = 1; k <= kReach; ++k)
    sum += 2.0 * c[static_cast<std::size_t>(k - 1)] * (order == 1 ? std::sin(k * angle) : 1.0 - std::cos(k * angle));
  return sum / (order == 1 ? angle : angle * angle);
}

Series derivative_error(const Series3& x, const RowTimes& rows) { return error_of_order(1, x, rows) / rows.step_s; }

Series second_derivative_error(const Series3& x, const RowTimes& rows) {
  return error_of_order(2, x, rows) / (rows.step_s * rows.step_s);
}

}  // namespace stillpoint::diag

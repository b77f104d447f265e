#include "simulation/smoothing_spline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stillpoint::sim {
namespace {

constexpr std::size_t kSupport = 6;  // coefficients that act at one time; also the bandwidth of the normal matrix
using Weights = std::array<Taylor, kSupport>;

/// The six basis functions that act at u in [0, 1) between two knots, times 120, as polynomials in u.
constexpr double kBasis[kSupport][6] = {{1, -5, 10, -10, 5, -1},    {26, -50, 20, 20, -20, 5}, {66, 0, -60, 0, 30, -10},
                                        {26, 50, 20, -20, -20, 10}, {1, 5, 10, 10, 5, -5},     {0, 0, 0, 0, 0, 1}};

Weights basis(const Taylor& u) {
  Weights w;
  for (std::size_t i = 0; i < kSupport; ++i) {
    Taylor sum;
    for (std::size_t k = 6; k-- > 0;) sum = sum * u + kBasis[i][k] / 120.0;
    w[i] = sum;
  }
  return w;
}

/// Symmetric banded matrix, lower half: row i holds columns i-5 ... i.
using Band = std::vector<std::array<double, kSupport>>;
double& entry(Band& a, std::size_t row, std::size_t column) { return a[row][column + kSupport - 1 - row]; }

void add_penalty(Band& a, double penalty) {
  constexpr double kFifth[kSupport] = {-1, 5, -10, 10, -5, 1};
  for (std::size_t i = 0; i + kSupport <= a.size(); ++i)
    for (std::size_t j = 0; j < kSupport; ++j)
      for (std::size_t k = 0; k <= j; ++k) entry(a, i + j, i + k) += penalty * kFifth[j] * kFifth[k];
}

/// Cholesky in place, then forward and back substitution.
template <class Point>
void solve_band(Band& a, std::vector<Point>& b) {
  const std::size_t n = a.size();
  const auto first = [](std::size_t i) { return i < kSupport ? 0 : i - kSupport + 1; };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = first(i); j <= i; ++j) {
      double sum = entry(a, i, j);
      for (std::size_t k = std::max(first(i), first(j)); k < j; ++k) sum -= entry(a, i, k) * entry(a, j, k);
      entry(a, i, j) = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / entry(a, j, j);
    }
    for (std::size_t k = first(i); k < i; ++k) b[i] -= entry(a, i, k) * b[k];
    b[i] /= entry(a, i, i);
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < std::min(n, i + kSupport); ++k) b[i] -= entry(a, k, i) * b[k];
    b[i] /= entry(a, i, i);
  }
}

/// Share of the samples' degrees of freedom that the fit uses: the mean of its gain over frequency.
double used_freedom(double penalty) {
  constexpr int kFrequencies = 400;
  double sum = 0.0;
  for (int i = 0; i < kFrequencies; ++i) sum += spline_gain(0.5 * (i + 0.5) / kFrequencies, penalty);
  return sum / kFrequencies;
}

}  // namespace

double spline_gain(double frequency, double penalty) {
  const double w = 2.0 * std::numbers::pi * frequency;
  const double h = (66.0 + 52.0 * std::cos(w) + 2.0 * std::cos(2.0 * w)) / 120.0;
  return h * h / (h * h + penalty * std::pow(2.0 * std::sin(0.5 * w), 10));
}

const std::vector<double>& spline_penalties() {
  static const std::vector<double> all = [] {
    std::vector<double> out;
    for (double p = 1e-10; p < 2e9; p *= 10.0) out.push_back(p);
    return out;
  }();
  return all;
}

template <int Columns>
double cross_validated_penalty(const CurveSamples<Columns>& s, double knot_step_s) {
  double best = std::numeric_limits<double>::max(), chosen = spline_penalties().front();
  for (const double p : spline_penalties()) {
    if (p > 2e4) break;
    const double left = 1.0 - used_freedom(p);
    const double score = SmoothingSpline<Columns>(s, knot_step_s, p).residual(s) / (left * left);
    if (score >= best) continue;
    best = score;
    chosen = p;
  }
  return chosen;
}

template <int Columns>
SmoothingSpline<Columns>::SmoothingSpline(const CurveSamples<Columns>& s, double knot_step_s, double penalty)
    : start_s_(s.t_s.front()), step_s_(knot_step_s) {
  const auto intervals = static_cast<std::size_t>(std::ceil((s.t_s.back() - start_s_) / step_s_)) + 1;
  coefficients_.assign(intervals + kSupport - 1, Point::Zero());
  Band normal(coefficients_.size());
  for (auto& row : normal) row.fill(0.0);
  for (std::size_t i = 0; i < s.t_s.size(); ++i) {
    const double x = (s.t_s[i] - start_s_) / step_s_;
    const auto knot = static_cast<std::size_t>(x);
    const Weights w = basis({x - static_cast<double>(knot), 0.0, 0.0});
    for (std::size_t j = 0; j < kSupport; ++j) {
      coefficients_[knot + j] += s.weight[i] * w[j].x * s.value[i];
      for (std::size_t k = 0; k <= j; ++k) entry(normal, knot + j, knot + k) += s.weight[i] * w[j].x * w[k].x;
    }
  }
  add_penalty(normal, penalty);
  solve_band(normal, coefficients_);
}

template <int Columns>
double SmoothingSpline<Columns>::residual(const CurveSamples<Columns>& s) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < s.t_s.size(); ++i) {
    const auto fit = at(s.t_s[i]);
    for (int c = 0; c < Columns; ++c)
      sum += s.weight[i] * std::pow(fit[static_cast<std::size_t>(c)].x - s.value[i][c], 2);
  }
  return sum;
}

template <int Columns>
std::array<Taylor, Columns> SmoothingSpline<Columns>::at(double t_s) const noexcept {
  const double last = static_cast<double>(coefficients_.size() - kSupport);
  const double x = std::clamp((t_s - start_s_) / step_s_, 0.0, last + 0.999999);
  const auto knot = static_cast<std::size_t>(x);
  const Weights w = basis({x - static_cast<double>(knot), 1.0 / step_s_, 0.0});
  std::array<Taylor, Columns> out{};
  for (std::size_t j = 0; j < kSupport; ++j)
    for (int c = 0; c < Columns; ++c)
      out[static_cast<std::size_t>(c)] = out[static_cast<std::size_t>(c)] + coefficients_[knot + j][c] * w[j];
  return out;
}

template <int Columns>
void SmoothingSpline<Columns>::hold(double from_s, double to_s, const Point& value) {
  // Coefficient j acts from knot j - 5 to knot j + 1 and peaks at j - 2.
  for (std::size_t j = 0; j < coefficients_.size(); ++j) {
    const double peak_s = start_s_ + step_s_ * (static_cast<double>(j) - 2.0);
    if (peak_s > from_s && peak_s < to_s) coefficients_[j] = value;
  }
}

template class SmoothingSpline<3>;
template class SmoothingSpline<4>;
template double cross_validated_penalty(const CurveSamples<3>&, double);
template double cross_validated_penalty(const CurveSamples<4>&, double);

}  // namespace stillpoint::sim

#include "simulation/allan.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace stillpoint::sim {
namespace {

using Row4 = std::array<double, kNoiseKinds>;

/// Share of each term, for coefficient one, in the Allan variance at tau.
Row4 shares(double tau_s) {
  return {3.0 / (tau_s * tau_s), 1.0 / tau_s, 2.0 * std::numbers::ln2 / std::numbers::pi, tau_s / 3.0};
}

double overlapping_variance(const std::vector<double>& integral, std::size_t m, double tau_s) {
  const std::size_t count = integral.size() - 2 * m;
  double sum = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double d = integral[k + 2 * m] - 2.0 * integral[k + m] + integral[k];
    sum += d * d;
  }
  return sum / (2.0 * tau_s * tau_s * static_cast<double>(count));
}

struct SubsetFit {
  double bic = std::numeric_limits<double>::infinity();
  Eigen::Vector4d squared = Eigen::Vector4d::Zero();
  Eigen::Vector4d variance = Eigen::Vector4d::Zero();
};

/// Least squares over the terms whose bit is set. Neighbouring points of an overlapping estimate share data, so about
/// one in three counts as new: the charge and the errors use that number.
SubsetFit fit_subset(std::span<const AllanPoint> points, unsigned subset) {
  constexpr double kPointsPerIndependent = 5.0;
  Eigen::MatrixXd A(static_cast<Eigen::Index>(points.size()), std::popcount(subset));
  Eigen::VectorXd b(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const AllanPoint& p = points[static_cast<std::size_t>(i)];
    const double variance = p.deviation * p.deviation;
    const double weight = 1.0 / (2.0 * p.relative_error * variance);  // the variance is twice as uncertain, relatively
    const Row4 row = shares(p.tau_s);
    for (Eigen::Index c = 0, k = 0; k < 4; ++k)
      if ((subset >> k & 1U) != 0) A(i, c++) = weight * row[static_cast<std::size_t>(k)];
    b[i] = weight * variance;
  }
  const Eigen::VectorXd scale = A.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = A * scale.asDiagonal();
  const Eigen::MatrixXd normal_inverse = (scaled.transpose() * scaled).inverse();
  const Eigen::VectorXd x = scale.asDiagonal() * (normal_inverse * (scaled.transpose() * b));
  if (!(x.array() >= 0.0).all()) return {};
  const double chi2 = (A * x - b).squaredNorm() / kPointsPerIndependent;
  SubsetFit fit;
  fit.bic = chi2 + std::popcount(subset) * std::log(static_cast<double>(A.rows()) / kPointsPerIndependent);
  for (Eigen::Index c = 0, k = 0; k < 4; ++k) {
    if ((subset >> k & 1U) == 0) continue;
    fit.squared[k] = x[c];
    fit.variance[k] = kPointsPerIndependent * normal_inverse(c, c) * scale[c] * scale[c];
    ++c;
  }
  return fit;
}

}  // namespace

std::vector<AllanPoint> allan_deviation(std::span<const double> reading, double dt_s) {
  constexpr double kPointsPerDecade = 10.0;
  constexpr std::size_t kFewestClusters = 9;
  std::vector<double> integral(reading.size() + 1, 0.0);
  double mean = 0.0;  // taken out first: the second difference does not see it, rounding does
  for (const double x : reading) mean += x / static_cast<double>(reading.size());
  for (std::size_t i = 0; i < reading.size(); ++i) integral[i + 1] = integral[i] + (reading[i] - mean) * dt_s;

  std::vector<AllanPoint> points;
  std::size_t last = 0;
  for (int step = 0;; ++step) {
    const auto m = static_cast<std::size_t>(std::llround(std::pow(10.0, step / kPointsPerDecade)));
    if (m * kFewestClusters > reading.size()) break;
    if (m == last) continue;
    last = m;
    const double tau_s = static_cast<double>(m) * dt_s;
    const double clusters = static_cast<double>(reading.size()) / static_cast<double>(m);
    const double variance = overlapping_variance(integral, m, tau_s);
    if (variance > 0.0) points.push_back({tau_s, std::sqrt(variance), 1.0 / std::sqrt(2.0 * (clusters - 1.0))});
  }
  return points;
}

NoiseTerms fit_noise_terms(std::span<const AllanPoint> points) {
  constexpr double kTwoSided95 = 1.96;
  NoiseTerms terms;
  if (points.size() < 4) return terms;
  SubsetFit best;
  for (unsigned subset = 1; subset < (1U << kNoiseKinds); ++subset) {
    const SubsetFit fit = fit_subset(points, subset);
    if (fit.bic < best.bic) best = fit;
  }
  for (std::size_t k = 0; k < kNoiseKinds; ++k) {
    const double squared = best.squared[static_cast<Eigen::Index>(k)];
    if (squared > 0.0) {
      terms.value[k] = std::sqrt(squared);
      terms.standard_error[k] = std::sqrt(best.variance[static_cast<Eigen::Index>(k)]) / (2.0 * terms.value[k]);
      continue;
    }
    // The largest value whose share stays inside the upper confidence bar at every averaging time.
    double limit = std::numeric_limits<double>::infinity();
    for (const AllanPoint& p : points) {
      const double predicted = predicted_deviation(terms, p.tau_s);
      const double top = std::max(p.deviation, predicted) * (1.0 + kTwoSided95 * p.relative_error);
      const double room = std::max(top * top - predicted * predicted, 0.0);
      limit = std::min(limit, room / shares(p.tau_s)[k]);
    }
    terms.upper_limit[k] = std::sqrt(limit);
  }
  return terms;
}

double predicted_deviation(const NoiseTerms& terms, double tau_s) {
  const Row4 row = shares(tau_s);
  double variance = 0.0;
  for (std::size_t k = 0; k < kNoiseKinds; ++k) variance += row[k] * terms.value[k] * terms.value[k];
  return std::sqrt(variance);
}

}  // namespace stillpoint::sim

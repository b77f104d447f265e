#include "diagnosis/reference/row_lateness.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "diagnosis/reference/columns.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeastSlope = 0.5;   // of a millisecond's change over the noise: slower rows say nothing
constexpr double kMostOfAMean = 4.0;  // of its deviations: more is a delay
constexpr double kAcross_s = 1.0;     // noise across the derivative is averaged over twice this

/// What a bias, a matrix, a delay and smooth curves explain, a column each, the same for every axis.
Eigen::MatrixXd smooth_design(const Signals& s, const Series3& v, const Series3& slope) {
  const WalkBasis walk = walk_basis(s);
  const Eigen::Index terms = std::min<Eigen::Index>(walk->cols(), 16);
  Eigen::MatrixXd design(s.n, 10 + terms);
  design << Eigen::VectorXd::Ones(s.n), v, slope, v.cwiseAbs2(), walk->leftCols(terms);
  for (Eigen::Index c = 0; c < design.cols(); ++c) design.col(c) /= std::max(design.col(c).norm(), 1e-12);
  return design;
}

/// `y` without these columns, fitted where deviations of `sd_s` in time lie along the derivative: across it alone they
/// are told then, and not by chance. `variance`: of each axis.
Series3 beside(Series3 y, const Mask& muted, const Eigen::MatrixXd& design, const Series3& slope, const Vec3& variance,
               double sd_s) {
  const Eigen::Index p = design.cols();
  Eigen::Matrix<double, Eigen::Dynamic, 9> weight = Eigen::Matrix<double, Eigen::Dynamic, 9>::Zero(y.rows(), 9);
  Series3 told = Series3::Zero(y.rows(), 3);
  for (Eigen::Index i = 0; i < y.rows(); ++i) {
    if (muted[static_cast<std::size_t>(i)]) continue;
    const Mat3 across = (Mat3(variance.asDiagonal()) + sd_s * sd_s * slope.row(i).transpose() * slope.row(i)).inverse();
    weight.row(i) = across.reshaped().transpose();
    told.row(i) = y.row(i) * across;
  }
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(3 * p, 3 * p);
  Eigen::VectorXd right(3 * p);
  for (int a = 0; a < 3; ++a) {
    right.segment(a * p, p) = design.transpose() * told.col(a);
    for (int b = 0; b < 3; ++b)
      if (const auto w = weight.col(3 * a + b); !w.isZero(0.0))
        normal.block(a * p, b * p, p, p) = design.transpose() * (w.asDiagonal() * design);
  }
  const Eigen::VectorXd theta = normal.completeOrthogonalDecomposition().solve(right);
  for (int a = 0; a < 3; ++a) y.col(a) -= design * theta.segment(a * p, p);
  return y;
}

/// Variance of each axis in the slower half of its rows, where jitter adds least: axes need not be equally noisy.
Vec3 quiet_variance(const Series3& left, const Series3& slope, const Mask& muted) {
  Vec3 out = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::pair<double, double>> rows;  // size of the derivative, square of the residual
    for (Eigen::Index i = 0; i < left.rows(); ++i)
      if (!muted[static_cast<std::size_t>(i)]) rows.emplace_back(std::abs(slope(i, axis)), std::pow(left(i, axis), 2));
    const auto half = static_cast<std::ptrdiff_t>(rows.size() / 2);
    if (half == 0) continue;
    std::nth_element(rows.begin(), rows.begin() + half, rows.end());
    for (auto row = rows.begin(); row != rows.begin() + half; ++row)
      out[axis] += row->second / static_cast<double>(half);
  }
  return out;
}

/// `variance`: of each axis.
TimedRows rows_beside(const Signals& s, Sensor k, const Seen& seen, const Vec3& variance, double sd_s) {
  TimedRows rows;
  rows.sensor = k;
  const Series3 slope = at_rest_zero(s, derivative(seen.vector, s.rows));
  const Series3 left = beside(seen.deviation, s.muted[k], smooth_design(s, seen.vector, slope), slope, variance, sd_s);
  const Vec3 quiet2 = quiet_variance(left, slope, s.muted[k]);
  Series across = Series::Zero(s.n), counted = across, along = across, quiet_along = across;
  for (Eigen::Index i = 0; i < s.n; ++i) {
    const Vec3 d = slope.row(i), v = seen.vector.row(i), r = left.row(i);
    if (s.muted[k][static_cast<std::size_t>(i)] || 1e-3 * d.norm() < 1e-2 * kLeastSlope * s.noise_sd[k]) continue;
    // Errors of the orientation turn the vector: they are alike along the derivative and across both.
    const Vec3 n = v.cross(d);
    if (!(n.norm() > 1e-9)) continue;
    const double quiet_across = n.cwiseAbs2().dot(quiet2);
    if (!(quiet_across > 0.0)) continue;
    across[i] = std::pow(r.dot(n), 2) / quiet_across, along[i] = r.dot(d) / d.norm(), counted[i] = 1.0;
    quiet_along[i] = d.cwiseAbs2().dot(quiet2) / d.squaredNorm();
  }
  const auto half = static_cast<Eigen::Index>(kAcross_s / s.dt_s);
  const Series mean = moving_mean(across, half).cwiseQuotient(moving_mean(counted, half).cwiseMax(1e-9));
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (counted[i] == 0.0 || !(mean[i] * quiet_along[i] > 0.0)) continue;
    rows.at.push_back(i);
    rows.along.push_back(along[i]);
    rows.slope.push_back(slope.row(i).norm());
    rows.noise.push_back(mean[i] * quiet_along[i]);
    rows.variance += mean[i] * quiet2;
  }
  rows.variance /= std::max(static_cast<double>(rows.at.size()), 1.0);
  return rows;
}

/// The likeliest deviation of each row.
Series deviations(const Signals& s, const std::vector<TimedRows>& sensors, double sd_s) {
  Series information = Series::Constant(s.n, 1.0 / (sd_s * sd_s)), evidence = Series::Zero(s.n);
  for (const TimedRows& r : sensors)
    for (std::size_t i = 0; i < r.at.size(); ++i) {
      information[r.at[i]] += r.slope[i] * r.slope[i] / r.noise[i];
      evidence[r.at[i]] += r.slope[i] * r.along[i] / r.noise[i];
    }
  return evidence.cwiseQuotient(information);
}

/// As many white deviations have a mean of their own, which is no delay. 0 where it is more than they have.
double mean_of(const Signals& s, const std::vector<TimedRows>& sensors, const std::array<Seen, kSensors>& seen,
               double sd_s) {
  double information = 0.0, evidence = 0.0;
  std::size_t rows = 0;
  for (const TimedRows& r : sensors) {
    const Series3& v = seen[r.sensor].vector;
    Eigen::MatrixXd design(s.n, 4);
    design << Eigen::VectorXd::Ones(s.n), v;
    const Series3 slope = at_rest_zero(s, derivative(v, s.rows));
    const auto free_of_it = [&](const Series3& x) {
      return beside(x, s.muted[r.sensor], design, slope, Vec3::Ones(), 0.0);
    };
    const Series3 left = free_of_it(seen[r.sensor].deviation), own = free_of_it(slope);
    for (const Eigen::Index i : r.at) {
      information += own.row(i).squaredNorm() / r.variance.mean();
      evidence += left.row(i).dot(own.row(i)) / r.variance.mean();
    }
    rows = std::max(rows, r.at.size());
  }
  const double late_s = evidence / information;
  return std::abs(late_s) < kMostOfAMean * sd_s / std::sqrt(static_cast<double>(rows)) ? late_s : 0.0;
}

}  // namespace

TimedRows rows_of(const Signals& s, Sensor k, const Seen& seen, double sd_s) {
  TimedRows rows = rows_beside(s, k, seen, Vec3::Ones(), 0.0);
  const Vec3 variance = rows.variance.cwiseMax(1e-6 * rows.variance.maxCoeff());  // an axis that never reads otherwise
  return sd_s > 0.0 ? rows_beside(s, k, seen, variance, sd_s) : rows;
}

Series lateness_of(const Signals& s, const std::vector<TimedRows>& sensors, const std::array<Seen, kSensors>& seen,
                   double sd_s) {
  Series late_s = deviations(s, sensors, sd_s);
  std::array<Seen, kSensors> left = seen;
  for (const TimedRows& r : sensors) left[r.sensor].deviation -= effect_of_lateness(s, seen[r.sensor].vector, late_s);
  late_s.array() += mean_of(s, sensors, left, sd_s);
  return late_s;
}

Series3 effect_of_lateness(const Signals& s, const Series3& vector, const Series& late_s) {
  return late_s.asDiagonal() * at_rest_zero(s, derivative(vector, s.rows)) +
         0.5 * late_s.cwiseAbs2().asDiagonal() * at_rest_zero(s, second_derivative(vector, s.rows));
}

}  // namespace stillpoint::diag

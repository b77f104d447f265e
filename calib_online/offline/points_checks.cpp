#include "calib_online/offline/points_checks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kPlane = 1e-5;                  // smallest over largest variance of points that do not lie in a plane
constexpr double kLargest = 1e60;                // fourth powers of readings must stay numbers
constexpr double kOpen = 0.33;                   // sd over radius: more, and the points do not determine it
constexpr double kThin = 30.0;                   // longest over shortest radius of what may still be a sensor
constexpr double kMisfit = 0.25;                 // of the radius, rms: such readings lie on no ellipsoid
constexpr double kTilt_rad = 20.0 * kRadPerDeg;  // a position by hand; its cosine spoils the radius by 6 %

bool leaves_open(const PointsFit& fit, std::size_t readings) {
  if (fit.covariance.size() == 0) return fit.radii && readings > 6;  // more readings than numbers, and yet no rank
  const double radius = 1.0 / std::cbrt(std::abs(fit.matrix.determinant()));
  for (int k = 0; k < 3; ++k) {
    if (std::sqrt(fit.covariance(k, k)) > kOpen * radius) return true;
    if (fit.radii && std::sqrt(fit.covariance(3 + k, 3 + k)) > kOpen * (*fit.radii)[k]) return true;
  }
  return false;
}

/// Which of the six positions the readings lack, "+x" for x up; empty: none.
std::string missing_position(const PointsFit& fit, std::span<const Point> points) {
  for (int k = 0; k < 6; ++k) {
    const double sign = k < 3 ? 1.0 : -1.0;
    double nearest_rad = std::numbers::pi;
    for (const Point& p : points) {
      const Vec3 u = fit.matrix * (p.y - fit.offset);
      nearest_rad = std::min(nearest_rad, std::acos(std::clamp(sign * u[k % 3] / u.norm(), -1.0, 1.0)));
    }
    if (!(nearest_rad < kTilt_rad))
      return std::string(sign > 0 ? "+" : "-") + "xyz"[k % 3] + " (the nearest is tilted by " +
             std::to_string(static_cast<int>(std::lround(nearest_rad * kDegPerRad))) + " deg)";
  }
  return {};
}

}  // namespace

PointsFit failed(FitStatus status, std::string reason) {
  PointsFit fit;
  fit.status = status;
  fit.reason = std::move(reason);
  fit.matrix.setZero();
  return fit;
}

std::optional<PointsFit> refuse(std::span<const Point> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].y.allFinite())
      return failed(FitStatus::kBadInput, "point " + std::to_string(i + 1) + " is not finite");
    if (points[i].variance && !(*points[i].variance >= 0.0 && std::isfinite(*points[i].variance)))
      return failed(FitStatus::kBadInput,
                    "the variance of point " + std::to_string(i + 1) + " is negative or not finite");
  }
  double largest = 0.0, variance = 0.0;
  for (const Point& p : points) {
    largest = std::max(largest, p.y.cwiseAbs().maxCoeff());
    variance += p.variance.value_or(0.0) / static_cast<double>(points.size());
  }
  if (largest > kLargest || (largest > 0.0 && largest < 1.0 / kLargest))
    return failed(FitStatus::kBadInput, "the readings are too large or too small to be computed with; another unit?");
  std::vector<Vec3> distinct;
  for (const Point& p : points) distinct.push_back(p.y);
  const auto order = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(distinct.begin(), distinct.end(), order);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  if (distinct.size() < 4)
    return failed(FitStatus::kTooFewPoints, std::to_string(points.size()) + " points, " +
                                                std::to_string(distinct.size()) +
                                                " of them distinct; at least 4 are needed");
  Vec3 mean = Vec3::Zero();
  for (const Vec3& y : distinct) mean += y / static_cast<double>(distinct.size());
  Mat3 S = Mat3::Zero();
  for (const Vec3& y : distinct) S += (y - mean) * (y - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(S);
  if (!(eigen.eigenvalues()[0] > kPlane * eigen.eigenvalues()[2]))
    return failed(FitStatus::kNotObservable, "the points lie in one plane");
  if (variance > S.trace() / (3.0 * static_cast<double>(distinct.size())))
    return failed(FitStatus::kNotObservable, "the stated variance is as large as the spread of the readings");
  return std::nullopt;
}

Eigen::MatrixXd covariance(const PointsFit& fit, std::span<const Point> points) {
  const int size = fit.radii ? 6 : 9;
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(size, size);
  double cost = 0.0;
  for (const Point& p : points) {
    const Vec3 z = p.y - fit.offset;
    const Vec3 u = fit.matrix * z;
    const double norm = u.norm();
    Eigen::VectorXd g(size);
    g.head<3>() = -fit.matrix.transpose() * u / norm;
    if (fit.radii) {
      g.tail<3>() = -u.cwiseProduct(u).cwiseQuotient(*fit.radii) / norm;
    } else {
      g.tail<6>() << u.x() * z.x(), u.x() * z.y(), u.x() * z.z(), u.y() * z.y(), u.y() * z.z(), u.z() * z.z();
      g.tail<6>() /= norm;
    }
    N += g * g.transpose();
    cost += (norm - 1.0) * (norm - 1.0);
  }
  const auto spare = static_cast<double>(points.size()) - size;
  if (spare < 1.0) return {};
  // Scale to a unit diagonal before asking for the rank: offsets and matrix entries differ by many digits.
  const Eigen::VectorXd d = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = d.asDiagonal() * N * d.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  if (!(eigen.eigenvalues()[0] > 1e-12)) return {};
  return (cost / spare) * (d.asDiagonal() * scaled.inverse() * d.asDiagonal());
}

double norm_rms(const PointsFit& fit, std::span<const Point> points) {
  double sum = 0.0;
  for (const Point& p : points) sum += std::pow((fit.matrix * (p.y - fit.offset)).norm() - 1.0, 2);
  return std::sqrt(sum / static_cast<double>(points.size()));
}

std::optional<PointsFit> refuse_result(Method method, const PointsFit& fit, std::span<const Point> points) {
  const auto open = [](const std::string& reason) { return failed(FitStatus::kNotObservable, reason); };
  if (!fit.offset.allFinite() || !fit.matrix.allFinite() || !(std::abs(fit.matrix.determinant()) > 0.0))
    return open("the fit is degenerate");
  const Vec3 lengths = fit.matrix.jacobiSvd().singularValues();
  if (lengths[0] > kThin * lengths[2])
    return open("the ellipsoid is all but flat: the points lie near a plane or a line");
  if (method == Method::kManual)
    if (const std::string lacking = missing_position(fit, points); !lacking.empty())
      return open("not six positions, each axis up and down: no reading shows " + lacking);
  if (const double rms = norm_rms(fit, points); rms > kMisfit)
    return open("the points lie on no ellipsoid: their norms are off by " +
                std::to_string(static_cast<int>(std::lround(100.0 * rms))) + " % (rms)");
  if (method != Method::kMap && leaves_open(fit, points.size()))
    return open("the points do not determine the centre or a radius: the directions are too few");
  return std::nullopt;
}

std::vector<std::string> violated_conditions(const PointsFit& fit, const PointsOptions& options) {
  std::vector<std::string> out;
  const double radius = 1.0 / std::cbrt(std::abs(fit.matrix.determinant()));
  const double spread = fit.offset.maxCoeff() - fit.offset.minCoeff();
  if (spread > radius) out.emplace_back("1: the centre's coordinates differ by more than a radius");
  if (options.converter_bits) {
    const double half = 0.5 * std::ldexp(1.0, *options.converter_bits);
    if (radius > half) out.emplace_back("3: the radius exceeds half the range of the converter");
  }
  if (options.full_scale_g) {
    const double expected = std::abs(fit.offset.mean()) / *options.full_scale_g;
    if (radius < 0.5 * expected || radius > 2.0 * expected)
      out.emplace_back("4: the radius is not what the sensitivity makes expected");
  }
  return out;
}

}  // namespace stillpoint::calib

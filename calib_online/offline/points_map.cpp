#include "calib_online/offline/points_map.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calib_online/offline/outliers.h"

namespace stillpoint::calib {
namespace {

constexpr double kNormSdUnknown = 0.003;  // first guess of the relative noise of a reading
constexpr double kNoisiest = 0.3;         // beyond, a reading says nothing of a sphere
constexpr double kParameters = 9.0;
constexpr double kWide = 0.02;  // least eigenvalue of (u, 1)(u, 1)^T: a cap of 60 deg has 0.01, a half sphere 0.06
constexpr double kShareOfPrior = 1.0 / 3.0;  // a sphere's own error, added to the prior's, is to change it by 5 % only
constexpr int kPasses = 8;

Mat3 squared(double sd) { return Mat3(sd * sd * Mat3::Identity()); }

Moments weighted(std::span<const Vec3> x, const std::vector<double>& weights) {
  Moments m;
  for (std::size_t i = 0; i < x.size(); ++i) m.add(x[i], weights[i]);
  return m;
}

/// Centre and upper triangle, of which PointsMap states the covariance. Pre: p is an ellipsoid.
Vec9 stated(const Vec9& p) {
  const auto e = ellipsoid(p);
  if (!e) return Vec9::Zero();
  const Mat3 U = upper_root(Mat3(e->K.transpose() * e->K));
  Vec9 out;
  out << e->centre, U(0, 0), U(0, 1), U(0, 2), U(1, 1), U(1, 2), U(2, 2);
  return out;
}

Mat9 covariance_of_stated(const MapFit& fit) {
  constexpr double kStep = 1e-6;  // p is about one
  Mat9 J;
  for (int k = 0; k < 9; ++k) {
    const Vec9 h = kStep * Vec9::Unit(k);
    J.col(k) = (stated(fit.p + h) - stated(fit.p - h)) / (2.0 * kStep);
  }
  return J * fit.covariance * J.transpose();
}

}  // namespace

Mat3 upper_root(const Mat3& A) { return Mat3(A.llt().matrixU()); }

bool shows_sphere(std::span<const Vec3> x, double prior_sd) {
  Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
  double cost = 0.0;
  for (const Vec3& p : x) {
    const double norm = std::max(1e-12, p.norm());
    Eigen::Vector4d g;
    g << p / norm, 1.0;
    N += g * g.transpose();
    cost += (norm - 1.0) * (norm - 1.0);
  }
  const double n = static_cast<double>(x.size());
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(N, Eigen::EigenvaluesOnly).eigenvalues()[0] / n;
  if (least > kWide) return true;
  if (!(least > 1e-12)) return false;
  // A few readings fit a sphere by chance: they are not taken for better than ordinary ones.
  const double variance = std::max(cost / std::max(1.0, n - 4.0), kNormSdUnknown * kNormSdUnknown / n);
  return std::sqrt(variance * N.inverse().diagonal().maxCoeff()) < kShareOfPrior * prior_sd;
}

PointsMap map_points(std::span<const Vec3> x, std::optional<double> noise_sd, double prior_sd) {
  const MapPrior prior{prior_sd, prior_sd, prior_sd};
  double sd = std::max(1e-9, noise_sd.value_or(kNormSdUnknown));
  std::vector<double> weights = first_weights(x, sd, prior);
  PointsMap out;
  MapFit fit;
  while (out.iterations < kPasses) {
    fit = map_fit(weighted(x, weights).adjusted(squared(sd)), sd, prior);
    if (fit.status != FitStatus::kOk) {
      // Noise taken for too small flattens an algebraic fit until it is no ellipsoid.
      if (noise_sd || sd > kNoisiest) return out;
      sd *= 2.0;
      continue;
    }
    ++out.iterations;
    const std::vector<double> errors = norm_errors(x, fit.ellipsoid);
    double sum = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) sum += weights[i] * errors[i] * errors[i];
    const double spare = static_cast<double>(x.size()) - kParameters;
    if (!noise_sd) sd = std::max(1e-6, std::sqrt(sum / std::max(1.0, spare)));
    weights = robust_weights(errors);
  }
  out.status = FitStatus::kOk;
  out.ellipsoid = fit.ellipsoid;
  // As many readings as parameters leave nothing over, which does not make them exact.
  const double spare = std::max(0.0, static_cast<double>(x.size()) - kParameters);
  const double stated_sd =
      noise_sd ? sd : std::sqrt((spare * sd * sd + kNormSdUnknown * kNormSdUnknown) / (spare + 1.0));
  const MapFit honest = map_fit(weighted(x, weights).adjusted(squared(stated_sd)), stated_sd, prior);
  fit.covariance = honest.covariance;
  out.covariance = covariance_of_stated(fit);
  return out;
}

}  // namespace stillpoint::calib

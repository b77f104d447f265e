#include "calib_online/offline/rival_fits.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace stillpoint::calib {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
constexpr double kStandsStill = 1e-10;
constexpr double kFarthest = 1e3;  // a radius or centre this far is the degenerate "zero error" solution

AxisParameters axis_from(const Vec6& v) { return {v.head<3>(), v.tail<3>()}; }
Vec6 stacked(const AxisParameters& a) {
  Vec6 v;
  v << a.centre, a.radii;
  return v;
}

struct Residual {
  double value;
  Vec6 gradient;
};
/// sum ((x - o)/s)^2 - 1
Residual equation_residual(const Vec3& x, const Vec6& v) {
  const Vec3 u = (x - v.head<3>()).cwiseQuotient(v.tail<3>());
  Residual r{u.squaredNorm() - 1.0, Vec6::Zero()};
  r.gradient << -2.0 * u.cwiseQuotient(v.tail<3>()), -2.0 * u.cwiseProduct(u).cwiseQuotient(v.tail<3>());
  return r;
}
/// |(x - o)/s| - 1
Residual norm_residual(const Vec3& x, const Vec6& v) {
  Residual r = equation_residual(x, v);
  const double norm = std::sqrt(r.value + 1.0);
  r.gradient /= 2.0 * std::max(norm, 1e-12);
  r.value = norm - 1.0;
  return r;
}

template <class F>
IteratedFit levenberg_marquardt(std::span<const Vec3> x, const AxisParameters& initial, int max_iterations,
                                F residual) {
  const auto cost_at = [&](const Vec6& v) {
    double sum = 0.0;
    for (const Vec3& p : x) sum += std::pow(residual(p, v).value, 2);
    return sum;
  };
  IteratedFit fit;
  Vec6 v = stacked(initial);
  double cost = cost_at(v), damping = 1e-3;
  for (fit.iterations = 1; fit.iterations <= max_iterations; ++fit.iterations) {
    Mat6 N = Mat6::Zero();
    Vec6 g = Vec6::Zero();
    for (const Vec3& p : x) {
      const Residual r = residual(p, v);
      N += r.gradient * r.gradient.transpose();
      g += r.gradient * r.value;
    }
    Mat6 damped = N;
    damped.diagonal() += damping * N.diagonal() + Vec6::Constant(1e-14);
    const Vec6 step = -damped.ldlt().solve(g);
    if (!step.allFinite()) break;
    const double next = cost_at(v + step);
    if (next <= cost) {
      v += step;
      damping = std::max(1e-12, damping / 10.0);
      const bool still = step.norm() < kStandsStill || cost - next < 1e-14 * (cost + 1e-30);
      cost = next;
      if (still) {
        fit.status = FitStatus::kOk;
        break;
      }
    } else if ((damping *= 10.0) > 1e12) {
      fit.status = FitStatus::kOk;  // no step lowers the cost: a minimum to rounding
      break;
    }
  }
  fit.axis = axis_from(v);
  fit.axis.radii = fit.axis.radii.cwiseAbs();
  if (!(v.cwiseAbs().maxCoeff() < kFarthest)) fit.status = FitStatus::kNotObservable;
  return fit;
}

}  // namespace

IteratedFit lin_min_var(std::span<const Vec3> x, const AxisParameters& initial, double prior_sd, double equation_sd,
                        int max_iterations) {
  const Vec6 prior = stacked(initial);
  IteratedFit fit;
  Vec6 v = prior;
  for (fit.iterations = 1; fit.iterations <= max_iterations; ++fit.iterations) {
    Mat6 P = prior_sd * prior_sd * Mat6::Identity();
    Vec6 estimate = prior;
    for (const Vec3& p : x) {
      const Residual r = equation_residual(p, v);
      const Vec6 Ph = P * r.gradient;
      const double S = r.gradient.dot(Ph) + equation_sd * equation_sd;
      const double predicted = r.value + r.gradient.dot(estimate - v);
      estimate -= Ph * (predicted / S);
      P -= Ph * Ph.transpose() / S;
    }
    const double step = (estimate - v).norm();
    v = estimate;
    if (!v.allFinite() || v.cwiseAbs().maxCoeff() > kFarthest) {
      fit.status = FitStatus::kNotObservable;
      return fit;
    }
    if (step < kStandsStill) {
      fit.status = FitStatus::kOk;
      break;
    }
  }
  fit.axis = axis_from(v);
  if (fit.axis.radii.minCoeff() <= 0.0) fit.status = FitStatus::kNotPositiveDefinite;
  return fit;
}

IteratedFit non_linear(std::span<const Vec3> x, const AxisParameters& initial, int max_iterations) {
  return levenberg_marquardt(x, initial, max_iterations, equation_residual);
}

IteratedFit lsq_non_linear(std::span<const Vec3> x, const AxisParameters& initial, int max_iterations) {
  return levenberg_marquardt(x, initial, max_iterations, norm_residual);
}

AxisParameters campolo_initial(std::span<const Vec3> x) {
  AxisParameters a;
  a.centre.setZero();
  for (const Vec3& p : x) a.centre += p / static_cast<double>(x.size());
  double r = 0.0;
  for (const Vec3& p : x) r += (p - a.centre).norm() / static_cast<double>(x.size());  // (G 4)
  a.radii.setConstant(r);
  return a;
}

EnclosingFit min_vol_ellipsoid(std::span<const Vec3> x, double tolerance, int max_iterations, bool away_steps) {
  using Vec4 = Eigen::Vector4d;
  using Mat4 = Eigen::Matrix4d;
  const auto n = x.size();
  std::vector<double> u(n, 1.0 / static_cast<double>(n));
  EnclosingFit fit;
  for (fit.iterations = 1; fit.iterations <= max_iterations; ++fit.iterations) {
    Mat4 X = Mat4::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec4 q(x[i].x(), x[i].y(), x[i].z(), 1.0);
      X += u[i] * q * q.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Mat4> eigen(X, Eigen::EigenvaluesOnly);
    if (!(eigen.eigenvalues()[0] > 1e-12 * eigen.eigenvalues()[3])) return fit;
    const Mat4 X_inv = X.inverse();
    double most = -1.0, least = 1e300;
    std::size_t i_most = 0, i_least = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec4 q(x[i].x(), x[i].y(), x[i].z(), 1.0);
      const double kappa = q.dot(X_inv * q);
      if (kappa > most) most = kappa, i_most = i;
      if (u[i] > 1e-12 && kappa < least) least = kappa, i_least = i;
    }
    const double up = most / 4.0 - 1.0, down = 1.0 - least / 4.0;
    if (up <= tolerance && (!away_steps || down <= tolerance)) {
      fit.status = FitStatus::kOk;
      break;
    }
    const bool away = away_steps && down > up;
    const std::size_t j = away ? i_least : i_most;
    const double kappa = away ? least : most;
    double step = (kappa - 4.0) / (4.0 * (kappa - 1.0));
    if (away) step = std::max(step, -u[j] / (1.0 - u[j]));
    for (double& v : u) v *= 1.0 - step;
    u[j] = std::max(0.0, u[j] + step);
  }
  if (fit.status != FitStatus::kOk) fit.status = FitStatus::kNotConverged;
  Vec3 c = Vec3::Zero();
  Mat3 S = Mat3::Zero();
  for (std::size_t i = 0; i < n; ++i) c += u[i] * x[i];
  for (std::size_t i = 0; i < n; ++i) S += u[i] * (x[i] - c) * (x[i] - c).transpose();
  fit.centre = c;
  fit.A = S.inverse() / 3.0;
  return fit;
}

IteratedFit manual_six_position(std::span<const Vec3> x) {
  IteratedFit fit;
  fit.iterations = 0;
  for (int k = 0; k < 3; ++k) {
    const auto by_axis = [k](const Vec3& a, const Vec3& b) { return a[k] < b[k]; };
    const auto [low, high] = std::minmax_element(x.begin(), x.end(), by_axis);
    const double margin = 0.01 * ((*high)[k] - (*low)[k]);
    double low_sum = 0, high_sum = 0;
    int low_n = 0, high_n = 0;
    for (const Vec3& p : x) {
      if (p[k] <= (*low)[k] + margin) low_sum += p[k], ++low_n;
      if (p[k] >= (*high)[k] - margin) high_sum += p[k], ++high_n;
    }
    fit.axis.centre[k] = 0.5 * (high_sum / high_n + low_sum / low_n);
    fit.axis.radii[k] = 0.5 * (high_sum / high_n - low_sum / low_n);
  }
  fit.status =
      fit.axis.radii.minCoeff() > 1e-6 * fit.axis.radii.maxCoeff() ? FitStatus::kOk : FitStatus::kNotObservable;
  return fit;
}

}  // namespace stillpoint::calib

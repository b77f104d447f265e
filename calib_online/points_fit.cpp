#include "calib_online/points_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib_online/rival_fits.h"

namespace stillpoint::calib {
namespace {

constexpr std::array<MethodName, 10> kMethods{{{Method::kLinAuto, "lin_auto"},
                                               {Method::kLinAutoRepeated, "lin_auto_repeated"},
                                               {Method::kLinMinVar, "lin_min_var"},
                                               {Method::kNonLinear, "non_linear"},
                                               {Method::kLsqNonLinear, "lsq_non_linear"},
                                               {Method::kMgn, "mgn"},
                                               {Method::kMinVolEllipsoid, "min_vol_ellipsoid"},
                                               {Method::kManual, "manual"},
                                               {Method::kAdjusted, "adjusted"},
                                               {Method::kMap, "map"}}};

constexpr int kRepeatedPasses = 12;       // (1:2:3 axes: 1e-5 at pass 5)
constexpr double kNormSdUnknown = 0.003;  // first guess of the relative noise of a reading
constexpr double kPlane = 1e-9;           // smallest over largest variance of points that do not lie in a plane

struct Working {
  std::vector<Vec3> x;
  Vec3 c0 = Vec3::Zero();
  double r0 = 1.0;
};

PointsFit failed(FitStatus status, std::string reason) {
  PointsFit fit;
  fit.status = status;
  fit.reason = std::move(reason);
  fit.matrix.setZero();
  return fit;
}

/// Empty when the points can be worked with; else the reason.
std::optional<PointsFit> refuse(std::span<const Point> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].y.allFinite())
      return failed(FitStatus::kBadInput, "point " + std::to_string(i + 1) + " is not finite");
    if (points[i].variance && !(*points[i].variance >= 0.0 && std::isfinite(*points[i].variance)))
      return failed(FitStatus::kBadInput,
                    "the variance of point " + std::to_string(i + 1) + " is negative or not finite");
  }
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
  return std::nullopt;
}

/// Centre and radius near the data, so that sums keep their digits: the sphere of step 1, or the mean where that fails.
Working working_coordinates(std::span<const Point> points, const PointsOptions& options) {
  Working w;
  for (const Point& p : points) w.x.push_back(p.y);
  const AxisParameters rough = campolo_initial(w.x);
  w.c0 = options.initial_centre.value_or(rough.centre);
  w.r0 = options.initial_radius.value_or(std::max(rough.radii[0], 1e-300));
  if (!options.initial_centre) {
    Moments m;
    for (const Point& p : points) m.add(Vec3((p.y - w.c0) / w.r0));
    const AxisFit sphere = lin_auto(m);
    // Only a sphere that encloses the points is nearer than their mean.
    if (sphere.sphere_radius > 0.1 && sphere.sphere_radius < 10.0) {
      w.c0 += w.r0 * sphere.centre;
      if (!options.initial_radius) w.r0 *= sphere.sphere_radius;
    }
  }
  for (Vec3& x : w.x) x = (x - w.c0) / w.r0;
  return w;
}

Mat3 upper_root(const Mat3& A) { return Mat3(A.llt().matrixU()); }

void set_axis(PointsFit& fit, const Working& w, const AxisParameters& a) {
  fit.offset = w.c0 + w.r0 * a.centre;
  fit.radii = Vec3(w.r0 * a.radii);
  fit.matrix = fit.radii->cwiseInverse().asDiagonal();
}
void set_general(PointsFit& fit, const Working& w, const Ellipsoid& e) {
  fit.offset = w.c0 + w.r0 * e.centre;
  fit.matrix = upper_root(Mat3(e.K.transpose() * e.K)) / w.r0;
}

PointsFit from_axis_fit(const Working& w, const Moments& m, int passes) {
  const AxisFit a = lin_auto(m, passes);
  if (a.status != FitStatus::kOk) {
    return failed(a.status,
                  a.unobserved_axis >= 0
                      ? std::string("the points do not determine the radius of axis ") + "xyz"[a.unobserved_axis]
                      : "the points lie on a plane or on two spheres at once: the normal matrix is singular");
  }
  PointsFit fit;
  set_axis(fit, w, {a.centre, a.radii});
  fit.iterations = passes;
  return fit;
}

PointsFit from_iterated(const Working& w, const IteratedFit& i) {
  if (i.status != FitStatus::kOk) {
    PointsFit fit = failed(i.status, i.status == FitStatus::kNotConverged
                                         ? "no minimum within the allowed iterations"
                                         : "the radii run to infinity: the directions do not surround the centre");
    fit.iterations = i.iterations;
    return fit;
  }
  PointsFit fit;
  set_axis(fit, w, i.axis);
  fit.iterations = i.iterations;
  return fit;
}

PointsFit from_general(const Working& w, const GeneralFit& g) {
  if (g.status != FitStatus::kOk) {
    return failed(g.status, g.status == FitStatus::kTooFewPoints ? "a general ellipsoid needs at least 9 points"
                            : g.status == FitStatus::kNotObservable
                                ? "the points lie on more than one quadric: their directions are too few"
                                : "the best quadric is no ellipsoid");
  }
  PointsFit fit;
  set_general(fit, w, g.ellipsoid);
  return fit;
}

std::optional<double> mean_variance(std::span<const Point> points, double r0) {
  double sum = 0.0;
  for (const Point& p : points) {
    if (!p.variance) return std::nullopt;
    sum += *p.variance / (r0 * r0);
  }
  return sum / static_cast<double>(points.size());
}

double norm_rms(const Working& w, const Ellipsoid& e) {
  double sum = 0.0;
  for (const Vec3& x : w.x) sum += std::pow((e.K * (x - e.centre)).norm() - 1.0, 2);
  return std::sqrt(sum / static_cast<double>(w.x.size()));
}

PointsFit map(const Working& w, const Moments& m, std::optional<double> variance, const PointsOptions& options) {
  const double sd = options.prior_relative_sd;
  const MapPrior prior{sd, sd, sd};
  double noise_sd = std::max(1e-9, variance ? std::sqrt(*variance) : kNormSdUnknown);
  MapFit f;
  PointsFit fit;
  const int passes = variance ? 1 : 4;
  for (fit.iterations = 1; fit.iterations <= passes; ++fit.iterations) {
    f = map_fit(m.adjusted(Mat3(noise_sd * noise_sd * Mat3::Identity())), noise_sd, prior);
    if (f.status != FitStatus::kOk) return failed(f.status, "the most likely quadric is no ellipsoid");
    // Unknown noise: what is left over, with the nine parameters' share given back.
    const double n = static_cast<double>(w.x.size());
    if (!variance) noise_sd = std::max(1e-6, norm_rms(w, f.ellipsoid) * std::sqrt(n / std::max(1.0, n - 9.0)));
  }
  --fit.iterations;
  set_general(fit, w, f.ellipsoid);
  return fit;
}

PointsFit dispatch(Method method, const Working& w, std::span<const Point> points, const PointsOptions& options) {
  Moments m;
  for (const Vec3& x : w.x) m.add(x);
  const AxisParameters start;  // the working coordinates are the initial values
  const int limit = options.max_iterations;
  switch (method) {
    case Method::kLinAuto:
      return from_axis_fit(w, m, 1);
    case Method::kLinAutoRepeated:
      return from_axis_fit(w, m, kRepeatedPasses);
    case Method::kLinMinVar:
      return from_iterated(w, lin_min_var(w.x, start, 1.0, 0.02, limit));
    case Method::kNonLinear:
      return from_iterated(w, non_linear(w.x, start, limit));
    case Method::kLsqNonLinear:
      return from_iterated(w, lsq_non_linear(w.x, campolo_initial(w.x), limit));
    case Method::kMgn:
      return from_general(w, general_fit(m));
    case Method::kAdjusted:
      return from_general(w, adjusted_fit(m, mean_variance(points, w.r0).value_or(-1.0)));
    case Method::kMap:
      return map(w, m, mean_variance(points, w.r0), options);
    case Method::kManual:
      return from_iterated(w, manual_six_position(w.x));
    case Method::kMinVolEllipsoid:
      break;
  }
  const EnclosingFit e = min_vol_ellipsoid(w.x, options.min_vol_tolerance, 20 * limit);
  if (e.status != FitStatus::kOk) return failed(e.status, "Khachiyan's iteration did not reach its tolerance");
  PointsFit fit;
  fit.offset = w.c0 + w.r0 * e.centre;
  fit.matrix = upper_root(e.A) / w.r0;
  fit.iterations = e.iterations;
  return fit;
}

/// Covariance by Gauss-Newton at the result, from the residuals of the norm: parameters offset, then radii or matrix.
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

/// Section 2.1's conditions 1, 3 and 4 (2 is the singular matrix).
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

}  // namespace

std::span<const MethodName> methods() { return kMethods; }

std::optional<Method> method_named(std::string_view name) {
  for (const auto& m : kMethods)
    if (m.name == name) return m.method;
  return std::nullopt;
}

PointsFit fit_points(Method method, std::span<const Point> points, const PointsOptions& options) {
  if (auto refusal = refuse(points)) return *refusal;
  const Working w = working_coordinates(points, options);
  PointsFit fit = dispatch(method, w, points, options);
  if (fit.status != FitStatus::kOk) return fit;
  if (!fit.offset.allFinite() || !fit.matrix.allFinite() || !(std::abs(fit.matrix.determinant()) > 0.0))
    return failed(FitStatus::kNotObservable, "the fit is degenerate");
  double sum = 0.0;
  for (const Point& p : points) sum += std::pow((fit.matrix * (p.y - fit.offset)).norm() - 1.0, 2);
  fit.residual_rms = std::sqrt(sum / static_cast<double>(points.size()));
  if (method != Method::kManual && method != Method::kMinVolEllipsoid) fit.covariance = covariance(fit, points);
  fit.conditions = violated_conditions(fit, options);
  return fit;
}

}  // namespace stillpoint::calib

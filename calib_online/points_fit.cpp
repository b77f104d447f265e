#include "calib_online/points_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib_online/outliers.h"
#include "calib_online/points_checks.h"
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
constexpr double kThin = 30.0;            // longest over shortest radius of what may still be a sensor
constexpr double kRunAway = 1.2;          // the repetition is to leave less misfit than the first pass, not more
constexpr double kGross = 0.4;            // of the radius: more than any sensor's bias and scale leave of a sphere
constexpr int kMapPasses = 8;

struct Working {
  std::vector<Vec3> x;
  Vec3 c0 = Vec3::Zero();
  double r0 = 1.0;
};

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

double axis_rms(const Working& w, const AxisFit& a) {
  double sum = 0.0;
  for (const Vec3& x : w.x) sum += std::pow((x - a.centre).cwiseQuotient(a.radii).norm() - 1.0, 2);
  return std::sqrt(sum / static_cast<double>(w.x.size()));
}

PointsFit from_axis_fit(const Working& w, const Moments& m, int passes) {
  const AxisFit a = lin_auto(m, passes);
  if (a.status != FitStatus::kOk) {
    return failed(a.status,
                  a.unobserved_axis >= 0
                      ? std::string("the points do not determine the radius of axis ") + "xyz"[a.unobserved_axis]
                      : "the points lie on a plane or on two spheres at once: the normal matrix is singular");
  }
  if (passes > 1) {
    const AxisFit once = lin_auto(m);
    if (once.status == FitStatus::kOk && axis_rms(w, a) > kRunAway * axis_rms(w, once))
      return failed(FitStatus::kNotConverged, "the repetition runs away from the points: their directions are too few");
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

PointsFit map(const Working& w, std::optional<double> variance, const PointsOptions& options) {
  const double prior_sd = options.prior_relative_sd, n = static_cast<double>(w.x.size());
  const MapPrior prior{prior_sd, prior_sd, prior_sd};
  double noise_sd = std::max(1e-9, variance ? std::sqrt(*variance) : kNormSdUnknown);
  std::vector<double> weights = first_weights(w.x, noise_sd, prior);
  PointsFit fit;
  MapFit f;
  for (fit.iterations = 0; fit.iterations < kMapPasses; ++fit.iterations) {
    Moments m;
    for (std::size_t i = 0; i < w.x.size(); ++i) m.add(w.x[i], weights[i]);
    f = map_fit(m.adjusted(Mat3(noise_sd * noise_sd * Mat3::Identity())), noise_sd, prior);
    if (f.status != FitStatus::kOk) return failed(f.status, "the most likely quadric is no ellipsoid");
    const std::vector<double> errors = norm_errors(w.x, f.ellipsoid);
    double sum = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) sum += weights[i] * errors[i] * errors[i];
    // Unknown noise: what is left over, with the nine parameters' share given back.
    if (!variance) noise_sd = std::max(1e-6, std::sqrt(sum / std::max(1.0, n - 9.0)));
    weights = huber_weights(errors);
  }
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
      return map(w, mean_variance(points, w.r0), options);
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

std::vector<std::size_t> gross(std::span<const Point> points) {
  std::vector<Vec3> y;
  for (const Point& p : points) y.push_back(p.y);
  return gross_outliers(y, kGross);
}

}  // namespace

std::span<const MethodName> methods() { return kMethods; }

std::optional<Method> method_named(std::string_view name) {
  for (const auto& m : kMethods)
    if (m.name == name) return m.method;
  return std::nullopt;
}

PointsFit fit_points(Method method, std::span<const Point> table, const PointsOptions& options) {
  if (auto refusal = refuse(table)) return *refusal;
  const std::vector<std::size_t> aside = method == Method::kMap ? gross(table) : std::vector<std::size_t>{};
  std::vector<Point> points;
  for (std::size_t i = 0; i < table.size(); ++i)
    if (!std::binary_search(aside.begin(), aside.end(), i)) points.push_back(table[i]);
  const Working w = working_coordinates(points, options);
  PointsFit fit = dispatch(method, w, points, options);
  if (fit.status != FitStatus::kOk) return fit;
  fit.set_aside = aside;
  if (!fit.offset.allFinite() || !fit.matrix.allFinite() || !(std::abs(fit.matrix.determinant()) > 0.0))
    return failed(FitStatus::kNotObservable, "the fit is degenerate");
  const Vec3 lengths = fit.matrix.jacobiSvd().singularValues();
  if (lengths[0] > kThin * lengths[2])
    return failed(FitStatus::kNotObservable, "the ellipsoid is all but flat: the points lie near a plane or a line");
  double sum = 0.0;
  for (const Point& p : points) sum += std::pow((fit.matrix * (p.y - fit.offset)).norm() - 1.0, 2);
  fit.residual_rms = std::sqrt(sum / static_cast<double>(points.size()));
  if (method != Method::kManual && method != Method::kMinVolEllipsoid) fit.covariance = covariance(fit, points);
  if (method != Method::kMap && leaves_open(fit))
    return failed(FitStatus::kNotObservable,
                  "the points do not determine the centre or a radius: the directions are too few");
  fit.conditions = violated_conditions(fit, options);
  return fit;
}

}  // namespace stillpoint::calib

#include "calib_online/offline/points_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib_online/offline/outliers.h"
#include "calib_online/offline/points_checks.h"
#include "calib_online/offline/points_map.h"
#include "calib_online/offline/rival_fits.h"

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

constexpr int kRepeatedPasses = 12;  // (1:2:3 axes: 1e-5 at pass 5)
constexpr double kRunAway = 1.2;     // the repetition is to leave less misfit than the first pass, not more
constexpr double kGross = 0.4;       // of the radius: more than any sensor's bias and scale leave of a sphere

struct Working {
  std::vector<Vec3> x;
  Vec3 c0 = Vec3::Zero();
  double r0 = 1.0;
  bool is_sphere = false;  ///< c0 and r0 are stated, or those of a sphere that the readings show
};

double mean_distance(std::span<const Point> points, const Vec3& from) {
  double sum = 0.0;
  for (const Point& p : points) sum += (p.y - from).norm();
  return sum / static_cast<double>(points.size());
}

/// Centre and radius near the data, so that sums keep their digits: the sphere of step 1, or the mean where that fails.
Working working_coordinates(std::span<const Point> points, const PointsOptions& options) {
  Working w;
  for (const Point& p : points) w.x.push_back(p.y);
  w.c0 = options.initial_centre.value_or(campolo_initial(w.x).centre);
  w.r0 = options.initial_radius.value_or(std::max(mean_distance(points, w.c0), 1e-300));
  w.is_sphere = options.initial_centre.has_value();
  if (!options.initial_centre) {
    Moments m;
    for (const Point& p : points) m.add(Vec3((p.y - w.c0) / w.r0));
    const AxisFit sphere = lin_auto(m);
    // Only a sphere that encloses the points is nearer than their mean.
    w.is_sphere = sphere.sphere_radius > 0.1 && sphere.sphere_radius < 10.0;
    if (w.is_sphere) {
      w.c0 += w.r0 * sphere.centre;
      if (!options.initial_radius) w.r0 *= sphere.sphere_radius;
    }
  }
  for (Vec3& x : w.x) x = (x - w.c0) / w.r0;
  return w;
}

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

/// The methods that have neither a prior nor a second step cannot make six numbers out of five readings.
PointsFit enough_readings(const Working& w, PointsFit fit) {
  if (w.x.size() < 6) return failed(FitStatus::kTooFewPoints, "a centre and three radii need at least 6 readings");
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
  const bool known = w.is_sphere && (options.initial_centre || shows_sphere(w.x, options.prior_relative_sd));
  if (!known)
    return failed(FitStatus::kNotObservable,
                  "the readings do not show the sphere that the prior is to be about; state its centre and radius");
  const PointsMap m =
      map_points(w.x, variance ? std::optional(std::sqrt(*variance)) : std::nullopt, options.prior_relative_sd);
  if (m.status != FitStatus::kOk)
    return failed(m.status, variance ? "the most likely quadric is no ellipsoid: is the stated variance too small?"
                                     : "the most likely quadric is no ellipsoid");
  PointsFit fit;
  set_general(fit, w, m.ellipsoid);
  fit.iterations = m.iterations;
  Vec9 unit;
  unit << Vec3::Constant(w.r0), Eigen::Matrix<double, 6, 1>::Constant(1.0 / w.r0);
  fit.covariance = unit.asDiagonal() * m.covariance * unit.asDiagonal();
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
      return enough_readings(w, from_iterated(w, non_linear(w.x, start, limit)));
    case Method::kLsqNonLinear:
      return enough_readings(w, from_iterated(w, lsq_non_linear(w.x, campolo_initial(w.x), limit)));
    case Method::kMgn:
      return from_general(w, general_fit(m));
    case Method::kAdjusted:
      return from_general(w, adjusted_fit(m, mean_variance(points, w.r0).value_or(-1.0)));
    case Method::kMap:
      return map(w, mean_variance(points, w.r0), options);
    case Method::kManual:
      return enough_readings(w, from_iterated(w, manual_six_position(w.x)));
    case Method::kMinVolEllipsoid:
      break;
  }
  const EnclosingFit e = min_vol_ellipsoid(w.x, options.min_vol_tolerance, 100 * limit);
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
  if (fit.covariance.size() == 0) fit.covariance = covariance(fit, points);
  if (auto refusal = refuse_result(method, fit, points)) return *refusal;
  fit.residual_rms = norm_rms(fit, points);
  // Readings inside an enclosing ellipsoid and at six hand-held positions do not scatter about the fit as noise does.
  if (method == Method::kManual || method == Method::kMinVolEllipsoid) fit.covariance.resize(0, 0);
  fit.conditions = violated_conditions(fit, options);
  return fit;
}

}  // namespace stillpoint::calib

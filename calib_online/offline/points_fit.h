/// The calibration methods that Gietzelt et al. compare, on a table of static readings, beside ours. Offline: may
/// allocate. After Gietzelt et al., sections 1.1 and 2.1; Lotters et al. 1998 [LinMinVarEstimate]; Lukowicz et al. 2004
/// [NonLinear]; Campolo et al. 2006 [LsqNonLinear, (G 4)]; Merayo et al. 2000 [MgnCalibration]; Todd, Yildirim 2007
/// [MinVolEllipsoid].
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib_online/offline/ellipsoid_fit.h"

namespace stillpoint::calib {

enum class Method {
  kLinAuto,
  kLinAutoRepeated,
  kLinMinVar,
  kNonLinear,
  kLsqNonLinear,
  kMgn,
  kMinVolEllipsoid,
  kManual,
  kAdjusted,
  kMap,
};
struct MethodName {
  Method method;
  std::string_view name;
};
[[nodiscard]] std::span<const MethodName> methods();
[[nodiscard]] std::optional<Method> method_named(std::string_view name);

struct Point {
  Vec3 y = Vec3::Zero();
  std::optional<double> variance;  ///< of that reading, per axis
};

/// What is known beforehand; everything is optional. The four error-handling conditions of section 2.1 use it.
struct PointsOptions {
  std::optional<Vec3> initial_centre;  ///< default: the sphere of step 1
  std::optional<double> initial_radius;
  std::optional<int> converter_bits;   ///< condition 3: readings lie in [0, 2^bits)
  std::optional<double> full_scale_g;  ///< condition 4: the radius should be near the centre over this
  double prior_relative_sd = 0.1;      ///< of the MAP prior, about the initial sphere
  int max_iterations = 1000;
  double min_vol_tolerance = 1e-6;  ///< Khachiyan; the paper's figures need 0.05
};

struct PointsFit {
  FitStatus status = FitStatus::kOk;
  std::string reason;  ///< empty when ok
  Vec3 offset = Vec3::Zero();
  std::optional<Vec3> radii;       ///< of the methods that fit an axis-parallel ellipsoid
  Mat3 matrix = Mat3::Identity();  ///< upper triangular (G 3): reading minus offset to unit vector
  Eigen::MatrixXd covariance;      ///< of the offset, then the radii (6) or the matrix's upper triangle (9); 0x0: none
  double residual_rms = 0.0;       ///< of |u| - 1
  int iterations = 0;
  std::vector<std::string> conditions;  ///< which of section 2.1's conditions the result violates
  std::vector<std::size_t> set_aside;   ///< kMap: indices of readings too far from all others to be believed
};

/// Never throws, never NaN in an ok result. Non-finite points, fewer than four distinct ones, points in a plane, and
/// points that leave the centre or a radius open by a third of it give a status. kMap bears outliers (Huber weights).
[[nodiscard]] PointsFit fit_points(Method method, std::span<const Point> points, const PointsOptions& options = {});

}  // namespace stillpoint::calib

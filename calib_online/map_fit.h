/// The ellipsoid that the moment sums and what is known beforehand make most likely (docs/math/ellipsoid.md). Fixed
/// size, no allocation, in the coordinates of the sums. The form is ours.
#pragma once
#include "calib_online/fit_status.h"
#include "calib_online/moments.h"
#include "calib_online/quadric.h"

namespace stillpoint::calib {

/// Prior sd relative to the radius, about the unit sphere at the origin of the working coordinates.
struct MapPrior {
  double scale_sd = 0.05, shear_sd = 0.05, centre_sd = 0.1;
};
struct MapFit {
  FitStatus status = FitStatus::kOk;
  Vec9 p = Vec9::Zero();
  Mat9 covariance = Mat9::Zero();  ///< of p
  Ellipsoid ellipsoid;
  double norm_sd = 0.0;        ///< rms over the sphere of the predicted sd of the calibrated norm
  double worst_norm_sd = 0.0;  ///< its largest, towards `worst_direction`
  Vec3 worst_direction = Vec3::UnitZ();
};
/// `m` holds adjusted sums with weight one a window; `norm_sd` is the sd of the norm of one of them, same unit as x.
[[nodiscard]] MapFit map_fit(const Moments& m, double norm_sd, const MapPrior& prior) noexcept;

}  // namespace stillpoint::calib

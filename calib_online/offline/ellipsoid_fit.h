/// Ellipsoid fits from the moment sums: LinAutoCalibration as printed and repeated, the general algebraic fit and the
/// noise-adjusted fit (docs/math/ellipsoid.md). Fixed size, no allocation. All work in the coordinates of the sums.
/// After Gietzelt et al. eqs. (5)-(17) [LinAuto]; Merayo et al. 2000 as coded by Barraud [general, |p| = 1]; Kukush,
/// Markovsky, Van Huffel 2004 [adjusted].
#pragma once
#include "calib_online/fit_status.h"
#include "calib_online/moments.h"
#include "calib_online/quadric.h"

namespace stillpoint::calib {

/// Axis-parallel ellipsoid, Gietzelt eq. (1).
struct AxisFit {
  FitStatus status = FitStatus::kNotObservable;
  Vec3 centre = Vec3::Zero();
  Vec3 radii = Vec3::Ones();
  double sphere_radius = 0.0;  ///< (G 12): the rms radius of the sphere of step 1, not the largest as the paper says
  int unobserved_axis = -1;    ///< whose 1/s^2 came out negative
};

/// Both steps as printed, with (G 11)'s first right-hand entry corrected to sum E_i; `passes` > 1 divides each axis by
/// the last radius and repeats both from the same sums.
[[nodiscard]] AxisFit lin_auto(const Moments& m, int passes = 1) noexcept;

struct GeneralFit {
  FitStatus status = FitStatus::kNotObservable;
  Ellipsoid ellipsoid;
  double noise_variance = 0.0;  ///< that was removed, per axis
};

/// Smallest eigenvector of the 10x10 normal matrix, |p| = 1: "MgnCalibration".
[[nodiscard]] GeneralFit general_fit(const Moments& m) noexcept;
/// The same after removing noise of variance s per axis; s < 0: unknown, the smallest s that makes the matrix singular.
[[nodiscard]] GeneralFit adjusted_fit(const Moments& m, double noise_variance) noexcept;

}  // namespace stillpoint::calib

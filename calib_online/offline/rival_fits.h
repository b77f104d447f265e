/// The iterative methods of Gietzelt's comparison, in working coordinates (radius about 1, centre near the origin).
/// Offline; they serve the comparison tables and `stillpoint calibrate`.
#pragma once
#include <span>

#include "calib_online/fit_status.h"
#include "calib_online/quadric.h"

namespace stillpoint::calib {

/// Initial values and result of the methods on (G 1): centre and radii.
struct AxisParameters {
  Vec3 centre = Vec3::Zero();
  Vec3 radii = Vec3::Ones();
};
struct IteratedFit {
  FitStatus status = FitStatus::kNotConverged;
  AxisParameters axis;
  int iterations = 0;
};

/// Lotters: linear minimum variance estimate, the equation (G 1) linearised about the last result, one reading at a
/// time, from the initial values with the prior sd `prior_sd`; repeated until it stands still.
[[nodiscard]] IteratedFit lin_min_var(std::span<const Vec3> x, const AxisParameters& initial, double prior_sd,
                                      double equation_sd, int max_iterations);
/// Lukowicz: Levenberg-Marquardt on the equation (G 1) itself.
[[nodiscard]] IteratedFit non_linear(std::span<const Vec3> x, const AxisParameters& initial, int max_iterations);
/// Campolo: Levenberg-Marquardt on the error of the norm.
[[nodiscard]] IteratedFit lsq_non_linear(std::span<const Vec3> x, const AxisParameters& initial, int max_iterations);
/// Campolo's initial values: the mean, and (G 4).
[[nodiscard]] AxisParameters campolo_initial(std::span<const Vec3> x);

struct EnclosingFit {
  FitStatus status = FitStatus::kNotObservable;
  Vec3 centre = Vec3::Zero();
  Mat3 A = Mat3::Identity();  ///< (x - c)^T A (x - c) <= 1
  int iterations = 0;
};
/// Khachiyan's minimum-volume enclosing ellipsoid with away steps (Todd, Yildirim, algorithm 4.2), to `tolerance`.
/// Without away steps and with tolerance 0.05 it is the program that the paper used.
[[nodiscard]] EnclosingFit min_vol_ellipsoid(std::span<const Vec3> x, double tolerance, int max_iterations,
                                             bool away_steps = true);

/// By hand: each axis turned up and down; centre and radius from the extreme readings of each axis (their means where
/// several lie within a fiftieth of a radius).
[[nodiscard]] IteratedFit manual_six_position(std::span<const Vec3> x);

}  // namespace stillpoint::calib

/// Before and after a fit of a table of points: what cannot be worked with, and how well the result is known.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib_online/offline/points_fit.h"

namespace stillpoint::calib {

[[nodiscard]] PointsFit failed(FitStatus status, std::string reason);

/// Empty when the points can be worked with; else the status and its reason.
[[nodiscard]] std::optional<PointsFit> refuse(std::span<const Point> points);

/// By Gauss-Newton at the result, from the residuals of the norm: of the offset, then the radii or the matrix's upper
/// triangle. 0x0 without a point to spare, or where some direction is not seen at all.
[[nodiscard]] Eigen::MatrixXd covariance(const PointsFit& fit, std::span<const Point> points);

/// rms of |matrix (reading - offset)| - 1.
[[nodiscard]] double norm_rms(const PointsFit& fit, std::span<const Point> points);

/// Empty when the result can be believed; else the status and its reason: degenerate or all but flat, readings that
/// lie on no ellipsoid, a centre or radius known no better than to a third of the radius (kMap has its prior for
/// those), a position that kManual needs and does not find. Without spare readings nobody can say how well.
[[nodiscard]] std::optional<PointsFit> refuse_result(Method method, const PointsFit& fit,
                                                     std::span<const Point> points);

/// Gietzelt et al., section 2.1: which of the conditions 1, 3 and 4 the result violates (2 is the singular matrix).
[[nodiscard]] std::vector<std::string> violated_conditions(const PointsFit& fit, const PointsOptions& options);

}  // namespace stillpoint::calib

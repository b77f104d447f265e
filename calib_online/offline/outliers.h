/// Readings that spoil a table of points. One of them, far away, draws every least-squares fit to itself and hides:
/// the fit to start from is that which leaves most readings the least, after Rousseeuw, "Least median of squares
/// regression", JASA 1984; from there Huber's weights. Offline: allocates.
#pragma once
#include <span>
#include <vector>

#include "calib_online/map_fit.h"

namespace stillpoint::calib {

/// Rising indices of the readings whose distance from the centre is off by more than `tolerance` of the radius, of the
/// sphere that most readings lie on. Empty when fewer than eight readings would be left, or less than three in four.
[[nodiscard]] std::vector<std::size_t> gross_outliers(std::span<const Vec3> readings, double tolerance);

/// | |K (x - centre)| - 1 | of each reading.
[[nodiscard]] std::vector<double> norm_errors(std::span<const Vec3> readings, const Ellipsoid& e);

/// min(1, 3 s/|e|)^3 with the robust s = 1.4826 median |e|. All one for fewer than 18 readings: among so few, with nine
/// parameters, the one that fits worst need not be wrong.
[[nodiscard]] std::vector<double> robust_weights(const std::vector<double>& errors);

/// The same from the MAP fit, among those to random halves of the readings, that leaves the smallest median error.
[[nodiscard]] std::vector<double> first_weights(std::span<const Vec3> readings, double norm_sd, const MapPrior& prior);

}  // namespace stillpoint::calib

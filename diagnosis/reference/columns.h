/// Builders of regression columns from drivers, and the drivers that need a formula of their own.
#pragma once
#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {

/// One column an axis, each with its own coefficient: k o x.
[[nodiscard]] Columns diagonal(const Series3& x);
/// A full 3x3 matrix of coefficients times x, row-major.
[[nodiscard]] Columns matrix_of(const Series3& x);
/// The names of those nine: letter_xx, letter_xy, ...
[[nodiscard]] std::vector<std::string> entries(const std::string& letter);
/// One scalar driver with a coefficient an axis.
[[nodiscard]] Columns on_each_axis(const Series& x);
/// Vectors with one coefficient each, common to the axes.
[[nodiscard]] Columns coupled(std::initializer_list<Series3> parts);
/// A vector fixed in the world, with free components there.
[[nodiscard]] Columns world_fixed(const Signals& s);

/// From the first row on; what a row says lasts to the next.
[[nodiscard]] Series integral(const Series& rate, double dt_s);

/// T - T_L with tau dT_L/dt = T - T_L, started in equilibrium.
[[nodiscard]] Series lagged_difference(const Series& T, double dt_s, double tau_s);
/// What is left of x when an adaptive bias estimate, started at zero, follows it at rest with time constant tau and
/// holds in motion.
[[nodiscard]] Series after_tracker(const Series& x, const Mask& rest, double dt_s, double tau_s);
/// omega' x e_j + omega x (omega x e_j): what a point 1 m along axis j senses more than the reference point.
[[nodiscard]] Series3 lever_column(const Signals& s, int j);
/// The same with arms of its own for every axis: nine coefficients, row-major.
[[nodiscard]] Columns size_columns(const Signals& s);
/// R' K p with nine free entries: any field that is linear in the place.
[[nodiscard]] Columns linear_in_place(const Signals& s);
/// R' (G p + b) where no current flows: G is symmetric and its trace is zero. Of G_xx, G_xy, G_xz, G_yy, G_yz, and the
/// three of b, which is the field at the middle of all places.
[[nodiscard]] Columns gradient_columns(const Signals& s);
/// The gradient with these five numbers.
[[nodiscard]] Mat3 gradient_of(const Eigen::Ref<const Eigen::VectorXd>& five);
/// R' (d x R f): what the accelerometer shows where the attitudes' world is turned by d against that of the positions.
[[nodiscard]] Columns turned_columns(const Signals& s);
/// What one sensor shows of a reference that is smoothed over s, or drawn as lines between frames s sqrt(6) apart, by
/// s^2/2. The second derivative of an attitude is a turn of omega' of the body: vectors turn by it, rates differ by its
/// own rate, omega'' + omega x omega'. With `places` those are smoothed as well, and so is the acceleration.
[[nodiscard]] Columns smoothing_columns(const Signals& s, Sensor sensor, bool places);
[[nodiscard]] Series3 at_rest_zero(const Signals& s, Series3 x);

}  // namespace stillpoint::diag

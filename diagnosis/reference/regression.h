/// Generalised least squares of one sensor's residual on the candidate physics, with a new bias and matrix fitted
/// beside it always, and a random walk where the recording needs one.
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "diagnosis/reference/noise_model.h"
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// One coefficient's contribution to the residual: n x 1 in the given axis, or n x 3 in all of them (axis -1).
struct Column {
  int axis = -1;
  Eigen::MatrixXd x;
};
using Columns = std::vector<Column>;

/// The column as it shows in one axis, no copy; empty where it does not.
[[nodiscard]] inline std::optional<Eigen::Map<const Series>> shown_in(const Column& c, int axis) {
  if (c.axis >= 0 && c.axis != axis) return std::nullopt;
  return Eigen::Map<const Series>(c.x.col(c.axis >= 0 ? 0 : axis).data(), c.x.rows());
}

/// What the columns do with these coefficients, in all three axes (n x 3).
[[nodiscard]] Series3 contribution_of(const Columns& columns, const Eigen::VectorXd& theta, Eigen::Index n);

[[nodiscard]] inline Columns joined(Columns a, const Columns& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// n x K cosines of a random walk on the recording's length; of megabytes, so every target of a search has the same.
using WalkBasis = std::shared_ptr<const Eigen::MatrixXd>;

/// One sensor's side of the problem, the same for every hypothesis.
struct Target {
  Sensor sensor = kAcc;
  Layout layout;
  Series3 residual;
  Eigen::MatrixXd nuisance;  ///< n x 4: one and the true vector; each axis has its own four coefficients
  WalkBasis walk;            ///< nullptr: none is allowed
  double duration_s = 0.0;
  RowTimes rows;
  [[nodiscard]] Eigen::Index walk_terms() const { return walk ? walk->cols() : 0; }
};

[[nodiscard]] Target make_target(const Signals& s, Sensor sensor);
/// cos(k pi t / T), k = 1..K, down to about the given period.
[[nodiscard]] WalkBasis walk_basis(const Series& t_s, double duration_s, double shortest_period_s);
[[nodiscard]] inline WalkBasis walk_basis(const Signals& s, double shortest_period_s = 8.0) {
  return walk_basis(s.t_s, s.duration_s(), shortest_period_s);
}

/// Prior deviations of the walk's coefficients k = 1..K: a walk with q unit/sqrt(s) has variance 2 q^2 T / (k pi)^2
/// there.
[[nodiscard]] Eigen::VectorXd walk_deviations(const Target& t, double q);

struct Fit {
  Eigen::VectorXd theta;       ///< of the candidate columns
  Eigen::MatrixXd covariance;  ///< of theta
  Eigen::VectorXd nuisance;    ///< 12: per axis offset and three of the matrix
  Eigen::MatrixXd nuisance_covariance;
  Series3 leftover;                ///< residual minus everything fitted
  Series3 whitened;                ///< of leftover
  double log_likelihood = 0.0;     ///< marginal over the walk
  std::array<double, 3> walk_q{};  ///< unit / sqrt(s)
};

/// With a given noise model, no walk re-estimated: for refining parameters.
[[nodiscard]] Fit fit_with(const Target& target, const Columns& columns, const NoiseModel& noise,
                           const std::array<double, 3>& walk_q);

/// Covariance of the columns' coefficients from what the residual did to them in each second, not from the noise model
/// being right (Liang and Zeger, Biometrika 73, 1986). Empty where too few seconds speak of them.
[[nodiscard]] Eigen::MatrixXd robust_covariance(const Target& target, const Columns& columns, const NoiseModel& noise,
                                                const std::array<double, 3>& walk_q);

/// With a given noise model, under which each axis walks at its most likely rate.
[[nodiscard]] Fit fit_walking(const Target& target, const Columns& columns, const NoiseModel& noise);

/// Noise and walk are estimated with the candidate inside, alternating to convergence.
[[nodiscard]] Fit fit_profile(const Target& target, const Columns& columns);

}  // namespace stillpoint::diag

#include "diagnosis/reference/settled_matrices.h"

#include "diagnosis/reference/fitted_matrix.h"

namespace stillpoint::diag {
namespace {

constexpr double kLikely = 0.05;  // deviation of an entry: of bare parts, mounted by hand
constexpr double kSeen = 30.0;    // chi-square of the difference

/// D as far as it is known, by a prior of kLikely.
Mat3 known_part(const Fit& fit) {
  Mat3 D = fitted_matrix(fit);
  for (int axis = 0; axis < 3; ++axis)
    D.row(axis) = under_prior(D.row(axis), fit.nuisance_covariance.block<3, 3>(4 * axis + 1, 4 * axis + 1),
                              Vec3::Constant(kLikely * kLikely));
  return D;
}

bool is_seen(const Series3& difference, const Layout& layout, const Fit& fit) {
  double chi2 = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double variance = (fit.leftover.col(axis).array().square() * layout.counts).sum() / layout.used();
    chi2 += (difference.col(axis).array().square() * layout.counts).sum() / variance;
  }
  return chi2 > kSeen;
}

void correct(Signals& s, Sensor k, const Mat3& C) {
  const auto apply = [&C](Series3& x) { x = (x * C.transpose()).eval(); };
  const bool stands_for_truth = vector_is_reading(s, k);
  s.residual[k] -= s.reading[k];  // what was taken out of it stays out
  apply(s.reading[k]);
  s.residual[k] += s.reading[k];
  s.triad[k].matrix = C * s.triad[k].matrix;
  if (!stands_for_truth) return;
  apply(s.vector[k]);
  if (k == kGyr) apply(s.rate), apply(s.rate_dot);
}

/// True where the readings of this sensor changed.
bool settle(Signals& s, const SensorSearch& search) {
  const Sensor k = search.sensor;
  const Series3 taken_out = s.residual[k] - search.target.residual;
  if (search.found.empty() && taken_out.isZero(0.0)) return false;
  const Fit fit = fit_profile(search.target, search.explained());
  const Mat3 D = known_part(fit);
  const Series3 law = taken_out + contribution_of(search.explained(), fit.theta, s.n);
  if (!D.allFinite() || !is_seen(law * D.transpose(), search.target.layout, fit)) return false;
  const Mat3 C = undoing(s, k, D);
  if (is_no_matrix(C)) return false;
  correct(s, k, C);
  return true;
}

}  // namespace

bool settle_matrices(Signals& s, const EngineResult& found) {
  bool any = false;
  for (const auto& search : found.sensor) any = (search && settle(s, *search)) || any;
  return any;
}

void settle_beside_laws(Signals& s, EngineResult& found) {
  for (auto& search : found.sensor) {
    if (!search || !search->has_unknown() || vector_is_reading(s, search->sensor)) continue;
    Series3& residual = search->target.residual;
    const Series3 taken_out = s.residual[search->sensor] - residual;
    if (settle(s, *search)) residual = s.residual[search->sensor] - taken_out;
  }
}

}  // namespace stillpoint::diag

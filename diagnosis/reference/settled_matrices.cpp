#include "diagnosis/reference/settled_matrices.h"

#include <Eigen/LU>

#include "core/directions.h"

namespace stillpoint::diag {
namespace {

constexpr double kLikely = 0.05;   // deviation of an entry: of bare parts, mounted by hand
constexpr double kSeen = 30.0;     // chi-square of the difference
constexpr double kNoMatrix = 2.0;  // a factor by which no wrong matrix stretches

/// residual = offset + D vector: D as far as it is known, by a prior of kLikely.
Mat3 known_part(const Fit& fit) {
  constexpr double kVariance = kLikely * kLikely;
  Mat3 D;
  for (int axis = 0; axis < 3; ++axis) {
    const Mat3 P = fit.nuisance_covariance.block<3, 3>(4 * axis + 1, 4 * axis + 1);
    const Vec3 d = fit.nuisance.segment<3>(4 * axis + 1);
    D.row(axis) = kVariance * (kVariance * Mat3::Identity() + P).partialPivLu().solve(d);
  }
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

}  // namespace

bool settle_matrices(Signals& s, const EngineResult& found) {
  bool any = false;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!found.sensor[k]) continue;
    const SensorSearch& search = *found.sensor[k];
    const Fit fit = fit_profile(search.target, search.explained());
    const Mat3 D = known_part(fit);
    const Series3 law = s.residual[k] - search.target.residual + contribution_of(search.explained(), fit.theta, s.n);
    if (!D.allFinite() || !is_seen(law * D.transpose(), search.target.layout, fit)) continue;
    const Mat3 C = vector_is_reading(s, k) ? Mat3(Mat3::Identity() - D) : Mat3((Mat3::Identity() + D).inverse());
    if (!C.allFinite() || distortion(C) > kNoMatrix) continue;  // of an axis that nothing excites
    correct(s, k, C);
    any = true;
  }
  return any;
}

}  // namespace stillpoint::diag

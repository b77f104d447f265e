#include "diagnosis/reference/drift.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/reference/wandering_reference.h"

namespace stillpoint::diag {
namespace {

constexpr double kDriftNats = 12.0;

/// Half of Wald's statistic of one effect, the walk fitted beside it.
double nats_beside_walk(const SensorSearch& search, std::size_t index, const Finished& finished) {
  const auto count = static_cast<Eigen::Index>(search.found[index].columns.size());
  const Eigen::Index first = first_column(search, index);
  const Eigen::VectorXd theta = finished.fit.theta.segment(first, count);
  const Eigen::MatrixXd covariance = finished.fit.covariance.block(first, first, count, count);
  return 0.5 * theta.dot(covariance.ldlt().solve(theta));
}

}  // namespace

bool drifts(const SensorSearch& search, const Finished& finished) {
  return finished.walk_gain_nats > std::max(kDriftNats, kLeastShareOfFirst * search.first_gain);
}

Finished finish_beside_drift(SensorSearch& search) {
  Finished finished = finish(search);
  for (std::size_t i = 0; i < search.found.size() && drifts(search, finished);) {
    const Found& f = search.found[i];
    // A response in time follows the motion, not the clock; its columns are but the tangent at what was found.
    const bool tried = f.timing.size() == 0 && f.kind != Kind::kConfiguration;
    if (!tried || nats_beside_walk(search, i, finished) > charge(f.columns.size(), f.window)) {
      ++i;
      continue;
    }
    take_out(search, i);
    finished = finish(search);
    i = 0;
  }
  return finished;
}

bool reference_may_drift(const Signals& s, const SensorSearch& search, const Finished& finished) {
  constexpr double kMarkers_rad = 3e-3;  // over the recording; the rate of a walk is known to a factor of two
  const Sensor sensor = search.sensor;
  if (s.exact_reference || sensor == kGyr) return false;
  if (!walks_beside_wandering(s, search, kDriftNats)) return true;
  const double fastest = *std::max_element(finished.fit.walk_q.begin(), finished.fit.walk_q.end());
  return fastest * std::sqrt(s.duration_s()) < kMarkers_rad * s.vector[sensor].rowwise().norm().mean();
}

bool walks_as_given(const Signals& s, Sensor sensor, const Finished& finished) {
  constexpr double kWithin = 3.0;  // rates are tried in factors of two, and one path tells little of its rate
  const sim::TriadConfig& given = s.triad[sensor];
  const double flicker = given.bias_instability * std::sqrt(2.0 * std::numbers::pi / s.duration_s());
  const auto& q = finished.fit.walk_q;
  return *std::max_element(q.begin(), q.end()) < kWithin * (given.random_walk_per_sqrts + flicker);
}

bool much_is_left(const Signals& s, const SensorSearch& search, const Finished& finished, const Diagnosis& told) {
  constexpr double kTimesTheNoise = 2.0;
  double noise_sd = s.noise_sd[search.sensor];
  if (!s.exact_reference || s.unresolved[search.sensor] || noise_sd <= 0) return false;
  for (const NoiseFault& n : told.noise)
    if (n.channel.starts_with(kSensorName[search.sensor])) noise_sd = std::max(noise_sd, n.measured);
  const Layout& layout = search.target.layout;
  double power = 0.0;
  bool white = true;
  for (int axis = 0; axis < 3; ++axis) {
    power += (finished.fit.leftover.col(axis).array().square() * layout.counts).sum() / std::max(layout.used(), 1.0);
    white = white && is_white(finished.fit.whitened.col(axis), layout);
  }
  return !white && std::sqrt(power / 3.0) > kTimesTheNoise * noise_sd;
}

}  // namespace stillpoint::diag

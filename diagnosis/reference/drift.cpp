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

/// From the first to the last half second whose mean power is above the limit. Whatever lasts so long drowns in a
/// minute's mean.
std::optional<Window> bursts(const Eigen::ArrayXd& power, const Eigen::ArrayXd& counts, double dt_s, double limit) {
  const auto rows = std::max<Eigen::Index>(1, std::lround(0.5 / dt_s));
  std::optional<Window> out;
  for (Eigen::Index begin = 0; begin + rows <= power.size(); begin += rows) {
    const double count = counts.segment(begin, rows).sum();
    if (count < 0.5 * static_cast<double>(rows) || power.segment(begin, rows).sum() < limit * count) continue;
    out = Window{true, out ? out->begin : begin, begin + rows};
  }
  return out;
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

std::optional<Window> left_over(const Signals& s, const SensorSearch& search, const Finished& finished,
                                const Diagnosis& told) {
  constexpr double kTimesTheNoise = 2.0, kTimesInABurst = 4.0, kShort = 0.5;
  double noise_sd = s.noise_sd[search.sensor];
  if (!s.exact_reference || s.unresolved[search.sensor] || noise_sd <= 0) return std::nullopt;
  for (const NoiseFault& n : told.noise)
    if (n.channel.starts_with(kSensorName[search.sensor])) noise_sd = std::max(noise_sd, n.measured);
  const Layout& layout = search.target.layout;
  const Eigen::ArrayXd power = finished.fit.leftover.rowwise().squaredNorm().array() * layout.counts / 3.0;
  if (const auto w = bursts(power, layout.counts, s.dt_s, std::pow(kTimesInABurst * noise_sd, 2)))
    return static_cast<double>(w->end - w->begin) < kShort * static_cast<double>(s.n) ? *w : Window{};
  bool white = true;
  for (int axis = 0; axis < 3; ++axis) white = white && is_white(finished.fit.whitened.col(axis), layout);
  const bool much = std::sqrt(power.sum() / std::max(layout.used(), 1.0)) > kTimesTheNoise * noise_sd;
  return much && !white ? std::optional(Window{}) : std::nullopt;
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/drift.h"

#include <Eigen/Cholesky>
#include <algorithm>

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

}  // namespace stillpoint::diag

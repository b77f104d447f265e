#include "simulation/whitening.h"

#include <cmath>

namespace stillpoint::sim {

Whitener::Whitener(const NoiseModel& noise) : white_variance_(noise.white * noise.white) {
  const auto n = static_cast<Eigen::Index>(noise.processes.size());
  keep_.resize(n);
  drive_variance_.resize(n);
  gain_.resize(n);
  covariance_.setZero(n, n);
  state_.setZero(n, 5);
  for (Eigen::Index i = 0; i < n; ++i) {
    const GaussMarkov& p = noise.processes[static_cast<std::size_t>(i)];
    keep_[i] = p.keep;
    drive_variance_[i] = p.drive * p.drive;
    covariance_(i, i) = p.start * p.start;
  }
}

Whitener::Row Whitener::whiten(const Row& signals) {
  gain_ = covariance_.rowwise().sum();  // of all processes, as the reading adds them up
  const double variance = gain_.sum() + white_variance_;
  if (!(variance > 0.0)) return Row::Zero();
  const Row innovation = signals - state_.colwise().sum();
  state_.noalias() += (gain_ / variance) * innovation;
  covariance_.noalias() -= (gain_ / variance) * gain_.transpose();
  return innovation / std::sqrt(variance);
}

void Whitener::advance() {
  state_.array().colwise() *= keep_.array();
  covariance_.array().colwise() *= keep_.array();
  covariance_.array().rowwise() *= keep_.transpose().array();
  covariance_.diagonal() += drive_variance_;
}

}  // namespace stillpoint::sim

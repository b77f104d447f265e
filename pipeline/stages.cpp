#include "pipeline/stages.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::pipeline {
namespace {

/// Nobody downstream can do anything with a quaternion that is not one.
bool publishable(const fusion::AttitudeEstimate& e) noexcept {
  double norm2 = 0.0;
  for (const double x : e.q_world_body) norm2 += x * x;
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::abs(norm2 - 1.0) < 1e-6 &&  // NaN fails as well
         std::all_of(e.rate_body_radps.begin(), e.rate_body_radps.end(), finite) &&
         std::all_of(e.covariance_world_rad2.begin(), e.covariance_world_rad2.end(), finite);
}

AttitudeStatus status_of(const Processed& p) noexcept {
  switch (p.attitude.status) {
    case fusion::AttitudeStatus::kWaiting:
      return AttitudeStatus::kInitializing;
    case fusion::AttitudeStatus::kOk:
      return p.after_gap || p.sample.clipped != 0 ? AttitudeStatus::kDegraded : AttitudeStatus::kOk;
    default:
      return AttitudeStatus::kDegraded;
  }
}

}  // namespace

AttitudeMessage to_message(const Processed& p, bool true_heading) noexcept {
  const fusion::AttitudeEstimate& e = p.attitude;
  AttitudeMessage m;
  m.t_ns = e.t_ns;
  m.sequence = p.sample.sequence;
  m.calibration_version = p.sample.calibration_version;
  m.q_world_body_xyzw = {e.q_world_body[1], e.q_world_body[2], e.q_world_body[3], e.q_world_body[0]};
  m.rate_radps = e.rate_body_radps;
  m.gyro_bias_radps = e.gyro_bias_radps;
  m.orientation_covariance_rad2 = e.covariance_world_rad2;
  m.sigma_rpy_rad = {e.sigma_roll_rad, e.sigma_pitch_rad, e.sigma_yaw_rad};
  if (p.temp_measured) m.temp_degC = p.sample.temp_degC;
  m.at_rest = e.at_rest;
  m.status = status_of(p);
  if (e.heading != fusion::HeadingReference::kRelative)
    m.heading_reference = true_heading ? HeadingReference::kTrue : HeadingReference::kMagnetic;
  return m;
}

StageStatus Stages::estimate(Processed& out) noexcept {
  const fusion::AttitudeEstimate estimate = filter_.step(out.sample, rest_.at_rest());
  if (estimate.status == fusion::AttitudeStatus::kRefused) return StageStatus::kDrop;
  out.attitude = in_frame(estimate, params_.frame);
  if (!publishable(out.attitude)) {
    ++counts_.gate_refused;
    filter_.reset(params_.initial_heading_rad);  // what is broken must not stay broken
    return StageStatus::kDrop;
  }
  return estimate.status == fusion::AttitudeStatus::kOk ? StageStatus::kOk : StageStatus::kDegraded;
}

}  // namespace stillpoint::pipeline

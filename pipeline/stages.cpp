#include "pipeline/stages.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

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

constexpr double kAnyAngle_rad = std::numbers::pi / std::numbers::sqrt3;  // even over the half turn to either side

/// Any attitude.
void state_ignorance(fusion::AttitudeEstimate& e) noexcept {
  e.covariance_world_rad2 = array(Mat3(kAnyAngle_rad * kAnyAngle_rad * Mat3::Identity()));
  e.sigma_roll_rad = e.sigma_pitch_rad = e.sigma_yaw_rad = kAnyAngle_rad;
  if (e.status == AttitudeStatus::kOk) e.status = AttitudeStatus::kDegraded;
}

/// No heading is less known than any heading.
void bound_heading(fusion::AttitudeEstimate& e) noexcept {
  if (e.sigma_yaw_rad <= kAnyAngle_rad) return;
  Mat3 P = mat(e.covariance_world_rad2);
  P.row(2) *= kAnyAngle_rad / e.sigma_yaw_rad;
  P.col(2) *= kAnyAngle_rad / e.sigma_yaw_rad;
  e.covariance_world_rad2 = array(P);
  fusion::set_sigmas(e);
}

AttitudeStatus status_of(const Processed& p) noexcept {
  const bool imperfect = p.after_gap || p.sample.clipped != 0 || p.health.worst() != Health::kOk;
  return p.attitude.status == AttitudeStatus::kOk && imperfect ? AttitudeStatus::kDegraded : p.attitude.status;
}

}  // namespace

AttitudeMessage to_message(const Processed& p) noexcept {
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
  if (p.temp_measured && p.health.temp.state != Health::kAbsent) m.temp_degC = p.sample.temp_degC;
  m.at_rest = e.at_rest;
  m.status = status_of(p);
  m.heading_reference = e.heading;
  m.health = p.health;
  return m;
}

/// Where two contradict each other (kAxes, kInconsistent) neither is known to be the wrong one.
CalibratedSample believed(const CalibratedSample& sample, const SensorsHealth& health) noexcept {
  CalibratedSample b = sample;
  for (const auto& [part, of] :
       {std::pair{kAcc, &health.acc}, std::pair{kGyr, &health.gyr}, std::pair{kMag, &health.mag}}) {
    if (of->state != Health::kFaulty || of->fault == Fault::kAxes || of->fault == Fault::kInconsistent) continue;
    b.has = static_cast<std::uint8_t>(b.has & ~part);
    b.absent = static_cast<std::uint8_t>(b.absent | part);
  }
  return b;
}

/// A driver knows its sensor, but nothing of what shakes it: its word makes the filter less sure, never surer.
fusion::WhiteNoise Stages::noise() const noexcept {
  const fusion::AttitudeFilterParams& configured = params_.attitude;
  const auto steps_s = guard_.usual_steps_s();
  const auto density = [&steps_s](double sd, SamplePart part) { return sd * std::sqrt(steps_s[part_index(part)]); };
  return {std::max(configured.gyr_noise_radps_rtHz, density(stated_.gyr_radps, kGyr)),
          std::max(configured.acc_noise_mps2_rtHz, density(stated_.acc_mps2, kAcc)),
          std::max(configured.mag_noise_uT, stated_.mag_uT)};
}

StageStatus Stages::estimate(const GuardedSample& guarded, Processed& out) noexcept {
  health_.hear(plausibility_.findings());
  filter_.use_noise(noise());
  fusion::AttitudeEstimate estimate = filter_.step(believed(out.sample, health_.now()), rest_.at_rest());
  if (estimate.refused) return StageStatus::kDrop;
  out.health = health_.observe(guarded, out.sample, estimate);
  const bool other_unit = out.health.gyr.fault == Fault::kUnits;
  if (other_unit_ && !other_unit) {  // what turned sixty times too far left nothing to go on from
    filter_.reset(params_.initial_heading_rad);
    estimate = filter_.step(out.sample, rest_.at_rest());
    if (estimate.refused) return StageStatus::kDrop;
  }
  other_unit_ = other_unit;
  if (HealthMonitor::unfounded(out.health)) state_ignorance(estimate);
  bound_heading(estimate);
  out.attitude = in_frame(estimate, params_.frame);
  if (!publishable(out.attitude)) {
    ++counts_.gate_refused;
    filter_.reset(params_.initial_heading_rad);  // what is broken must not stay broken
    return StageStatus::kDrop;
  }
  return estimate.status == AttitudeStatus::kOk ? StageStatus::kOk : StageStatus::kDegraded;
}

}  // namespace stillpoint::pipeline

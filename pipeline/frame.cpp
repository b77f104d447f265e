#include "pipeline/frame.h"

#include <cmath>

namespace stillpoint::pipeline {
namespace {

/// Standard deviation about a world axis of unit length.
double sigma_about(const Vec3& axis_world, const Array9& covariance) {
  return std::sqrt(std::max(0.0, axis_world.dot(mat(covariance) * axis_world)));
}

}  // namespace

void set_sigmas(fusion::AttitudeEstimate& e) noexcept {
  const Quat q_world_body(e.q_world_body[0], e.q_world_body[1], e.q_world_body[2], e.q_world_body[3]);
  // Roll and pitch errors turn about the horizontal axis of the heading and the one across it; the heading is that of
  // body x.
  Vec3 ahead = q_world_body * Vec3::UnitX();
  // With body x vertical there is no heading; its last meaningful stand-in is the horizontal part of body -z or +z.
  if (std::hypot(ahead.x(), ahead.y()) < 1e-6) ahead = q_world_body * Vec3::UnitZ();
  ahead.z() = 0.0;
  ahead.normalize();
  const Vec3 across(-ahead.y(), ahead.x(), 0.0);
  e.sigma_roll_rad = sigma_about(ahead, e.covariance_world_rad2);
  e.sigma_pitch_rad = sigma_about(across, e.covariance_world_rad2);
  e.sigma_yaw_rad = sigma_about(Vec3::UnitZ(), e.covariance_world_rad2);
}

fusion::AttitudeEstimate in_frame(const fusion::AttitudeEstimate& sensor_in_enu, const OutputFrame& frame) noexcept {
  fusion::AttitudeEstimate e = sensor_in_enu;
  const bool mounted = !frame.q_body_sensor.isApprox(Quat::Identity(), 0.0);
  if (mounted) {
    const auto& q = sensor_in_enu.q_world_body;
    const Quat q_world_body = (Quat(q[0], q[1], q[2], q[3]) * frame.q_body_sensor.conjugate()).normalized();
    e.q_world_body = {q_world_body.w(), q_world_body.x(), q_world_body.y(), q_world_body.z()};
    const Mat3 R_body_sensor = frame.q_body_sensor.toRotationMatrix();
    e.rate_body_radps = array(Vec3(R_body_sensor * vec(e.rate_body_radps)));
    set_sigmas(e);
  }
  if (frame.world == WorldFrame::kNed) e = fusion::in_ned(e);
  e.gyro_bias_radps = sensor_in_enu.gyro_bias_radps;  // as the calibration: of the sensor's axes
  return e;
}

CalibratedSample in_frame(const CalibratedSample& of_sensor, const OutputFrame& frame) noexcept {
  CalibratedSample body = of_sensor;
  for (Array3* v : {&body.acc_mps2, &body.gyr_radps, &body.mag_uT}) {
    *v = array(Vec3(frame.q_body_sensor * vec(*v)));
    if (frame.world == WorldFrame::kNed) *v = {(*v)[0], -(*v)[1], -(*v)[2]};
  }
  return body;
}

}  // namespace stillpoint::pipeline

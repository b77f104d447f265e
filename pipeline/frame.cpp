#include "pipeline/frame.h"

#include "core/so3.h"

namespace stillpoint::pipeline {

fusion::AttitudeEstimate in_frame(const fusion::AttitudeEstimate& sensor_in_enu, const OutputFrame& frame) noexcept {
  fusion::AttitudeEstimate e = sensor_in_enu;
  const bool mounted = !frame.q_body_sensor.isApprox(Quat::Identity(), 0.0);
  if (mounted) {
    e.q_world_body = array(quat(sensor_in_enu.q_world_body) * frame.q_body_sensor.conjugate());
    const Mat3 R_body_sensor = frame.q_body_sensor.toRotationMatrix();
    e.rate_body_radps = array(Vec3(R_body_sensor * vec(e.rate_body_radps)));
    fusion::set_sigmas(e);
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

#include "fusion/attitude_estimate.h"

#include <algorithm>
#include <cmath>

#include "fusion/attitude_storage.h"

namespace stillpoint::fusion {
namespace {

/// ENU to NED exchanges x and y and turns z: its own inverse, and a rotation (determinant +1).
const Mat3 kNedFromEnu = (Mat3() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
/// Forward-left-up to forward-right-down: half a turn about x.
Array3 frd(const Array3& flu) { return {flu[0], -flu[1], -flu[2]}; }

/// Standard deviation about a world axis of unit length.
double sigma_about(const Vec3& axis_world, const Mat3& covariance) {
  return std::sqrt(std::max(0.0, axis_world.dot(covariance * axis_world)));
}

}  // namespace

void set_sigmas(AttitudeEstimate& e) noexcept {
  const Mat3 covariance = mat(e.covariance_world_rad2);
  const Vec3 ahead = direction_of_heading(quat(e.q_world_body));
  e.sigma_roll_rad = sigma_about(ahead, covariance);
  e.sigma_pitch_rad = sigma_about(Vec3(-ahead.y(), ahead.x(), 0.0), covariance);
  e.sigma_yaw_rad = sigma_about(Vec3::UnitZ(), covariance);
}

AttitudeEstimate in_ned(const AttitudeEstimate& enu) noexcept {
  AttitudeEstimate ned = enu;
  // kNedFromEnu is half a turn about (1, 1, 0) / sqrt(2), the body's is half a turn about x.
  const double h = 0.70710678118654752440;
  ned.q_world_body = array(Quat(0, h, h, 0) * quat(enu.q_world_body) * Quat(0, 1, 0, 0));
  ned.covariance_world_rad2 = array(Mat3(kNedFromEnu * mat(enu.covariance_world_rad2) * kNedFromEnu.transpose()));
  ned.unexplained_rad2 = array(Mat3(kNedFromEnu * mat(enu.unexplained_rad2) * kNedFromEnu.transpose()));
  ned.rate_body_radps = frd(enu.rate_body_radps);
  ned.gyro_bias_radps = frd(enu.gyro_bias_radps);
  return ned;
}

}  // namespace stillpoint::fusion

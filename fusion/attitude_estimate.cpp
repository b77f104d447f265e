#include "fusion/attitude_estimate.h"

namespace stillpoint::fusion {
namespace {

/// ENU to NED exchanges x and y and turns z: its own inverse, and a rotation (determinant +1).
const Mat3 kNedFromEnu = (Mat3() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
/// Forward-left-up to forward-right-down: half a turn about x.
Array3 frd(const Array3& flu) { return {flu[0], -flu[1], -flu[2]}; }

}  // namespace

AttitudeEstimate in_ned(const AttitudeEstimate& enu) noexcept {
  AttitudeEstimate ned = enu;
  const Array4& q = enu.q_world_body;
  // kNedFromEnu is half a turn about (1, 1, 0) / sqrt(2), the body's is half a turn about x.
  const double h = 0.70710678118654752440;
  const Quat turned = Quat(0, h, h, 0) * Quat(q[0], q[1], q[2], q[3]) * Quat(0, 1, 0, 0);
  const double sign = turned.w() < 0 ? -1.0 : 1.0;
  ned.q_world_body = {sign * turned.w(), sign * turned.x(), sign * turned.y(), sign * turned.z()};
  ned.covariance_world_rad2 = array(Mat3(kNedFromEnu * mat(enu.covariance_world_rad2) * kNedFromEnu.transpose()));
  ned.rate_body_radps = frd(enu.rate_body_radps);
  ned.gyro_bias_radps = frd(enu.gyro_bias_radps);
  return ned;
}

}  // namespace stillpoint::fusion

#include "bench/baselines.h"

#include <cmath>

#include "core/directions.h"
#include "core/so3.h"

namespace stillpoint::bench {
namespace {

/// World field with the same dip and no east part: eqs. (45), (46) of Madgwick, and what Mahony takes for v_mag.
Vec3 field_reference(const Quat& q, const Vec3& mag) {
  const Vec3 world = q * mag;
  return {0.0, std::hypot(world.x(), world.y()), world.z()};
}

}  // namespace

Quat attitude_from_vectors(const Vec3& acc_mps2, const Vec3& mag_uT) {
  const Vec3 up = acc_mps2.normalized();
  const Vec3 east = mag_uT.cross(up);
  if (east.norm() < 1e-9) return turn_between(up, Vec3::UnitZ());
  Mat3 R_body_world;
  R_body_world.col(0) = east.normalized();
  R_body_world.col(1) = up.cross(east.normalized());
  R_body_world.col(2) = up;
  return Quat(Mat3(R_body_world.transpose()));
}

Quat Mahony::step(const BaselineInput& in) {
  if (!started_) q_ = attitude_from_vectors(in.acc_mps2, in.mag_uT);
  started_ = true;
  Vec3 error = Vec3::Zero();
  if (in.acc_mps2.norm() > 0.0) error += in.acc_mps2.normalized().cross(q_.conjugate() * Vec3::UnitZ());
  if (in.mag_uT.norm() > 0.0) {
    error += in.mag_uT.normalized().cross((q_.conjugate() * field_reference(q_, in.mag_uT)).normalized());
  }
  bias_ -= kI * error * in.dt_s;
  q_ = (q_ * exp_quat((in.gyr_radps - bias_ + kP * error) * in.dt_s)).normalized();
  return q_;
}

Quat Madgwick::step(const BaselineInput& in) {
  if (!started_) q_ = attitude_from_vectors(in.acc_mps2, in.mag_uT);
  started_ = true;
  // The gradient of |R(q)' d - s|^2 / 2 over q, eq. (20), for each pair of world direction d and reading s. With
  // e = R' d - s a turn phi of the body changes R' d by (R' d) x phi, and q by q (0, phi / 2): in that tangent the
  // gradient is e x (R' d) twice, which is the paper's J' f for a unit quaternion.
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
  const auto add = [&](const Vec3& direction_world, const Vec3& reading) {
    const Vec3 predicted = q_.conjugate() * direction_world;
    const Vec3 tangent = 2.0 * (predicted - reading).cross(predicted);
    const Quat step = q_ * Quat(0.0, tangent.x(), tangent.y(), tangent.z());
    gradient += Eigen::Vector4d(step.w(), step.x(), step.y(), step.z());
  };
  if (in.acc_mps2.norm() > 0.0) add(Vec3::UnitZ(), in.acc_mps2.normalized());
  if (in.mag_uT.norm() > 0.0) {
    const Vec3 reading = in.mag_uT.normalized();
    add(field_reference(q_, reading), reading);
  }
  if (gradient.norm() > 0.0) gradient.normalize();
  const Quat rate = q_ * Quat(0.0, 0.5 * in.gyr_radps.x(), 0.5 * in.gyr_radps.y(), 0.5 * in.gyr_radps.z());
  q_.coeffs() +=
      in.dt_s * (rate.coeffs() - kBeta * Eigen::Vector4d(gradient(1), gradient(2), gradient(3), gradient(0)));
  q_.normalize();
  return q_;
}

Quat Complementary::step(const BaselineInput& in) {
  if (!started_) q_ = attitude_from_vectors(in.acc_mps2, in.mag_uT);
  started_ = true;
  q_ = (q_ * exp_quat(in.gyr_radps * in.dt_s)).normalized();
  Quat target = attitude_from_vectors(in.acc_mps2, in.mag_uT);
  if (in.mag_uT.norm() == 0.0) {  // 6D: only the tilt is pulled
    target = turn_between(q_ * in.acc_mps2, Vec3::UnitZ()) * q_;
  }
  q_ = (exp_quat(in.dt_s / (kTime_s + in.dt_s) * log_quat(target * q_.conjugate())) * q_).normalized();
  return q_;
}

}  // namespace stillpoint::bench

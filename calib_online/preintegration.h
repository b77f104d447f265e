/// The rotation that a gyroscope has gone through, with its derivatives by the sensor's matrix and bias, so that it
/// need not be integrated anew when these change. docs/math/gyro.md (Y3), (Y4).
#pragma once
#include "core/so3.h"

namespace stillpoint::calib {

using Mat39 = Eigen::Matrix<double, 3, 9, Eigen::RowMajor>;

struct Preintegrated {
  Quat q = Quat::Identity();   ///< v_start = R(q) v_end
  Mat39 J = Mat39::Zero();     ///< rotation vector at the end, end axes, by the rows of H
  Mat3 J_bias = Mat3::Zero();  ///< the same by the bias, s

  /// (Y3) One step: `z` is the reading less its bias, rad/s, and H z the rate.
  void advance(const Vec3& z, const Mat3& H, double dt_s) noexcept {
    const Vec3 phi = H * z * dt_s;
    const Quat dq = exp_quat(phi);
    const Mat3 E_t = dq.conjugate().toRotationMatrix();
    const Mat3 Jr = right_jacobian(phi) * dt_s;
    const Mat39 turned = E_t.lazyProduct(J);  // any other product would make a copy by columns of three
    J = turned;
    for (int i = 0; i < 3; ++i) J.middleCols<3>(3 * i) += Jr.col(i) * z.transpose();
    J_bias = E_t * J_bias - Jr * H;
    q = renormalized(q * dq);
  }

  /// (Y4) What has come after `first`, with which this one began.
  [[nodiscard]] Preintegrated after(const Preintegrated& first) const noexcept {
    Preintegrated rest;
    rest.q = renormalized(first.q.conjugate() * q);
    const Mat3 R_t = rest.q.conjugate().toRotationMatrix();
    rest.J = J - R_t * first.J;
    rest.J_bias = J_bias - R_t * first.J_bias;
    return rest;
  }
};

}  // namespace stillpoint::calib

/// Open attitude filters written from their papers, so that the comparison needs no outside code. 9D and 6D; all start
/// from the same first sample and take the same corrected readings in SI units. Quaternions: body to world ENU.
#pragma once
#include "core/types.h"

namespace stillpoint::bench {

/// One sample for a baseline. mag_uT is zero for 6D.
struct BaselineInput {
  Vec3 acc_mps2, gyr_radps, mag_uT;
  double dt_s = 0.0;
};

/// Level by the accelerometer, north by the magnetometer; heading 0 without one.
[[nodiscard]] Quat attitude_from_vectors(const Vec3& acc_mps2, const Vec3& mag_uT);

/// Mahony, Hamel, Pflimlin, "Nonlinear complementary filters on the special orthogonal group" (2008), eqs. (32)-(34),
/// the explicit complementary filter. The paper's integral gain of 0.3 winds up on hand motion (mean total 32 degrees
/// on BROAD), so the smaller one that favours it stands here.
class Mahony {
 public:
  Quat step(const BaselineInput& in);

 private:
  static constexpr double kP = 1.0, kI = 0.003;
  Quat q_ = Quat::Identity();
  Vec3 bias_ = Vec3::Zero();
  bool started_ = false;
};

/// Madgwick, Harrison, Vaidyanathan, "Estimation of IMU and MARG orientation using a gradient descent algorithm"
/// (2011), eqs. (25)-(34) and (44)-(47); beta as in the author's published code.
class Madgwick {
 public:
  Quat step(const BaselineInput& in);

 private:
  static constexpr double kBeta = 0.1;
  Quat q_ = Quat::Identity();
  bool started_ = false;
};

/// The plain complementary filter: the gyroscope, pulled towards the attitude of the two vectors with a time constant.
class Complementary {
 public:
  Quat step(const BaselineInput& in);

 private:
  static constexpr double kTime_s = 10.0;
  Quat q_ = Quat::Identity();
  bool started_ = false;
};

}  // namespace stillpoint::bench

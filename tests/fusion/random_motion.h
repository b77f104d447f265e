/// A motion and a sensor for the filter's tests, written here so that they share no formula with the filter: the truth
/// is stepped at the sample rate, its velocity, turn rate and magnetic deviation wander as first-order processes.
#pragma once
#include <cmath>
#include <random>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::test {

struct MotionParams {
  double rate_hz = 100.0;
  double turn_radps = 1.0, turn_time_s = 1.0;
  double speed_mps = 0.5, speed_time_s = 0.5;
  double gyr_noise_radps_rtHz = 2e-4;
  double acc_noise_mps2_rtHz = 0.03;
  double gyr_bias_sd_radps = 0.01;
  double gyr_matrix_sd = 0.004;
  double acc_bias_sd_mps2 = 0.01;
  double gyr_bias_walk_radps_rtHz = 1e-4;
  double deviation_rad = 0.0, deviation_time_s = 10.0;  ///< of the magnetic heading of the place
  double mag_noise_uT = 0.3;
  Vec3 field_uT{0.0, 16.0, -40.0};
  Vec3 hard_iron_uT = Vec3::Zero();
};

class RandomMotion {
 public:
  RandomMotion(const MotionParams& params, unsigned seed) : p_(params), random_(seed) {
    bias_ = p_.gyr_bias_sd_radps * normal3();
    acc_bias_ = p_.acc_bias_sd_mps2 * normal3();
    for (int j = 0; j < 3; ++j) matrix_.col(j) = p_.gyr_matrix_sd * normal3();
    deviation_ = p_.deviation_rad * normal_(random_);
    // One draw a line: in which order the arguments of a call are evaluated is the compiler's choice.
    const double heading_rad = 3.0 * normal_(random_);
    const double pitch_rad = 0.3 * normal_(random_);
    q_ = exp_quat(Vec3(0.3 * normal_(random_), pitch_rad, heading_rad));
  }

  /// Advances the truth by one period and reads the sensors; `still` holds the body where it is.
  CalibratedSample next(bool still) {
    const double dt = 1.0 / p_.rate_hz;
    const Vec3 speed_before = speed_;
    if (still) {
      rate_.setZero();
      speed_.setZero();
      wish_.setZero();
    } else {
      wander(rate_, p_.turn_radps, p_.turn_time_s, dt);
      wander(wish_, p_.speed_mps, p_.speed_time_s, dt);
      speed_ += (1.0 - std::exp(-dt / kReaction_s)) * (wish_ - speed_);  // no hand changes its speed at once
    }
    deviation_ = std::exp(-dt / p_.deviation_time_s) * deviation_ +
                 std::sqrt(1.0 - std::exp(-2.0 * dt / p_.deviation_time_s)) * p_.deviation_rad * normal_(random_);
    bias_ += p_.gyr_bias_walk_radps_rtHz * std::sqrt(dt) * normal3();
    q_ = (q_ * exp_quat(rate_ * dt)).normalized();
    CalibratedSample s;
    s.t_ns = static_cast<std::int64_t>(std::llround(static_cast<double>(++n_) * dt * kNsPerSecond));
    s.sequence = n_;
    s.has = kAcc | kGyr | kMag;
    const double white = 1.0 / std::sqrt(dt);
    // rate = (I - M) u - b, solved for the reading u.
    const Vec3 wanted = rate_ + bias_ + p_.gyr_noise_radps_rtHz * white * normal3();
    s.gyr_radps = array(Vec3((Mat3::Identity() - matrix_).inverse() * wanted));
    const Vec3 force = (speed_ - speed_before) / dt + Vec3(0, 0, kStandardGravity_mps2);
    s.acc_mps2 = array(Vec3(q_.conjugate() * force + acc_bias_ + p_.acc_noise_mps2_rtHz * white * normal3()));
    const Quat turned(Eigen::AngleAxisd(deviation_, Vec3::UnitZ()));
    s.mag_uT = array(Vec3(q_.conjugate() * (turned * p_.field_uT) + p_.hard_iron_uT + p_.mag_noise_uT * normal3()));
    return s;
  }

  [[nodiscard]] const Quat& q_world_body() const { return q_; }
  [[nodiscard]] const Vec3& bias_radps() const { return bias_; }
  [[nodiscard]] const Mat3& gyr_matrix() const { return matrix_; }

 private:
  static constexpr double kReaction_s = 0.1;
  Vec3 normal3() { return {normal_(random_), normal_(random_), normal_(random_)}; }
  void wander(Vec3& x, double sd, double time_s, double dt) {
    const double keep = std::exp(-dt / time_s);
    x = keep * x + std::sqrt(1.0 - keep * keep) * sd * normal3();
  }

  MotionParams p_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Quat q_;
  Vec3 rate_ = Vec3::Zero(), speed_ = Vec3::Zero(), wish_ = Vec3::Zero(), bias_, acc_bias_;
  Mat3 matrix_;
  double deviation_ = 0.0;
  std::uint64_t n_ = 0;
};

/// Rotation error in world axes: q_true = exp(error) q_estimated.
inline Vec3 error_world(const Quat& truth, const Quat& estimate) { return log_quat(truth * estimate.conjugate()); }

}  // namespace stillpoint::test

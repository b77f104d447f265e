/// Truth for the tests of the calibration: raw readings from a motion, written here and nowhere else, so that no
/// formula is shared with what is tested. y = H^-1 u + B + noise.
#pragma once
#include <cmath>
#include <functional>
#include <random>

#include "core/types.h"

namespace stillpoint::test {

struct SensorTruth {
  Mat3 H_acc = Mat3::Identity(), H_gyr = Mat3::Identity(), H_mag = Mat3::Identity();
  Vec3 b_acc = Vec3::Zero(), b_gyr = Vec3::Zero(), b_mag = Vec3::Zero();
  double acc_noise_mps2 = 0.02, gyr_noise_radps = 0.001, mag_noise_uT = 0.3;
  bool has_mag = true;
  double rate_hz = 100.0;
};

/// What the body does at time t: its rate in body axes, its linear acceleration in body axes.
struct Motion {
  std::function<Vec3(double)> rate_radps = [](double) { return Vec3(Vec3::Zero()); };
  std::function<Vec3(double)> force_mps2 = [](double) { return Vec3(Vec3::Zero()); };
};

class Synthetic {
 public:
  Synthetic(const SensorTruth& truth, unsigned seed, const Quat& q_world_body = Quat::Identity())
      : truth_(truth), random_(seed), q_world_body_(q_world_body) {}

  /// Calls `take` with every sample of `duration_s` of the motion.
  template <class Take>
  void run(double duration_s, const Motion& motion, Take&& take) {
    const double dt = 1.0 / truth_.rate_hz;
    const auto n = static_cast<int>(std::lround(duration_s * truth_.rate_hz));
    for (int k = 0; k < n; ++k) {
      const Vec3 w = motion.rate_radps(dt * k);
      take(sample(w, motion.force_mps2(dt * k)));
      const Vec3 half = 0.5 * dt * w;
      q_world_body_ = (q_world_body_ * Quat(1.0, half.x(), half.y(), half.z())).normalized();
      t_ns_ += static_cast<std::int64_t>(std::llround(1e9 * dt));
    }
  }
  double temp_degC = 25.0;
  [[nodiscard]] Quat attitude() const { return q_world_body_; }
  void set_attitude(const Quat& q) { q_world_body_ = q; }
  [[nodiscard]] Vec3 noise(double sd) { return sd * Vec3(normal_(random_), normal_(random_), normal_(random_)); }
  SensorTruth& truth() { return truth_; }

 private:
  RawSample sample(const Vec3& w, const Vec3& linear) {
    RawSample s;
    s.t_ns = t_ns_;
    s.sequence = sequence_++;
    const Mat3 R_body_world = q_world_body_.toRotationMatrix().transpose();
    s.acc_mps2 = array(Vec3(truth_.H_acc.inverse() * (R_body_world * Vec3(0, 0, 9.80665) + linear) + truth_.b_acc +
                            noise(truth_.acc_noise_mps2)));
    s.gyr_radps = array(Vec3(truth_.H_gyr.inverse() * w + truth_.b_gyr + noise(truth_.gyr_noise_radps)));
    s.mag_uT = array(
        Vec3(truth_.H_mag.inverse() * (R_body_world * Vec3(0, 20, -43)) + truth_.b_mag + noise(truth_.mag_noise_uT)));
    s.temp_degC = temp_degC;
    s.has = static_cast<std::uint8_t>(kAcc | kGyr | kTemp | (truth_.has_mag ? kMag : 0));
    return s;
  }

  SensorTruth truth_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  Quat q_world_body_;
  std::int64_t t_ns_ = 1'000'000'000;
  std::uint64_t sequence_ = 0;
};

}  // namespace stillpoint::test

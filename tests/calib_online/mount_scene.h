/// A body that is laid down in one pose after the other, with sensors that sit on it in known ways.
#pragma once
#include <random>
#include <vector>

#include "calib_online/offline/mount_fit.h"
#include "core/so3.h"
#include "core/units.h"
#include "tests/calib_online/synthetic.h"

namespace stillpoint::test {

inline const Quat kLevel = Quat::Identity();
inline const Quat kFrontUp = exp_quat(Vec3(0, -std::numbers::pi / 2, 0));
inline const Quat kLeftUp = exp_quat(Vec3(std::numbers::pi / 2, 0, 0));
inline const Quat kRightUp = exp_quat(Vec3(-std::numbers::pi / 2, 0, 0));
inline const Quat kBottomUp = exp_quat(Vec3(std::numbers::pi, 0, 0));

/// How the sensors sit: body from accelerometer, accelerometer from the other two.
struct Sitting {
  Mat3 acc = Mat3::Identity(), gyr = Mat3::Identity(), mag = Mat3::Identity();
};

struct Imperfect {
  double pose_sd_rad = 0.0, acc_bias_mps2 = 0.0, acc_shape = 0.0, gyr_bias_radps = 0.0, gyr_shape = 0.0, iron_uT = 0.0,
         mag_shape = 0.0;
};
inline constexpr Imperfect kUsual{1.0 * kRadPerDeg, 0.15, 0.005, 0.02, 0.01, 20.0, 0.03};

/// Three seconds at rest in each pose, two from one to the next about one axis.
inline std::vector<RawSample> placements(const std::vector<Quat>& poses, const Sitting& sitting, unsigned seed,
                                         const Imperfect& errors = {}) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&](double sd) { return Vec3(sd * Vec3(normal(random), normal(random), normal(random))); };
  const auto shape = [&](double sd) {
    const Vec3 d = vector(sd), o = vector(sd);
    Mat3 S;
    S << 1 + d.x(), o.x(), o.y(), o.x(), 1 + d.y(), o.z(), o.y(), o.z(), 1 + d.z();
    return S;
  };
  SensorTruth truth;
  truth.H_acc = sitting.acc * shape(errors.acc_shape);
  truth.H_gyr = sitting.acc * sitting.gyr * shape(errors.gyr_shape);
  truth.H_mag = sitting.acc * sitting.mag * shape(errors.mag_shape);
  truth.b_acc = vector(errors.acc_bias_mps2);
  truth.b_gyr = vector(errors.gyr_bias_radps);
  truth.b_mag = vector(errors.iron_uT);
  Synthetic synthetic(truth, seed);
  std::vector<RawSample> samples;
  const auto take = [&samples](const RawSample& s) { samples.push_back(s); };
  static constexpr double kRest_s = 3.0, kTurn_s = 2.0;
  Quat now;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Quat pose = poses[i] * exp_quat(vector(errors.pose_sd_rad));
    if (i > 0) {
      const Vec3 way = log_quat(now.conjugate() * pose);
      Motion motion;
      motion.rate_radps = [way](double t_s) {
        return Vec3(way * (1.0 - std::cos(2.0 * std::numbers::pi * t_s / kTurn_s)) / kTurn_s);
      };
      synthetic.run(kTurn_s, motion, take);
    }
    synthetic.set_attitude(pose);
    synthetic.run(kRest_s, {}, take);
    now = pose;
  }
  return samples;
}

inline const std::vector<Quat> kManySides{kLevel, kFrontUp, kLeftUp, kLevel, kRightUp, kBottomUp};

inline Mat3 any_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Quat(normal(random), normal(random), normal(random), normal(random)).normalized().toRotationMatrix();
}

/// What is found from these poses of a body whose sensors sit so.
inline calib::MountFit fit(const std::vector<Quat>& poses, const Sitting& sitting, unsigned seed,
                           const Imperfect& errors = {}, calib::MountParams params = {}) {
  const std::vector<std::vector<RawSample>> recordings{placements(poses, sitting, seed, errors)};
  return calib::fit_mount(calib::mount_evidence(recordings), params);
}

}  // namespace stillpoint::test

/// A hand or a vehicle: what accelerates for long is no offset that has jumped, and what may be a lean is stated.
#include "core/units.h"
#include "fusion/motion_scale.h"
#include "simulation/random.h"
#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

constexpr double kStep_s = 0.02;
constexpr MotionScale::Usual kHand{1.0, 0.5};

/// East by `mps2`, seen upright.
MotionScale::Seen accelerating(double mps2) {
  return {{5.0, 0.0}, {0.04, 0.04}, {mps2, 0.0, kStandardGravity_mps2}, 1e-4, 0.0};
}

TEST(MotionScale, WhatIsCalledALongAccelerationMayBeALean) {
  MotionScale scale;
  EXPECT_EQ(scale.leaning_rad2(1e-4).norm(), 0.0);
  for (double t_s = 0.0; t_s < 30.0; t_s += kStep_s) (void)scale.observe(accelerating(2.0), kHand, kStep_s);
  const Mat3 leaning = scale.leaning_rad2(1e-4);
  // To the east means about the north: (2 / g)^2 of it, three parts in ten.
  EXPECT_NEAR(leaning(1, 1), 0.3 * std::pow(2.0 / kStandardGravity_mps2, 2), 0.002);
  EXPECT_NEAR(leaning(0, 0), 0.0, 1e-9);
  EXPECT_LT(scale.leaning_rad2(0.01).norm(), 1e-9);  // a tilt known no better explains it
  scale.rest();
  EXPECT_EQ(scale.leaning_rad2(1e-4).norm(), 0.0);
}

/// An aircraft that never rests: straight on, then round and round. The force stays along its own vertical.
class Circling {
 public:
  explicit Circling(unsigned seed) : random_(seed, "circling") {}
  CalibratedSample next() {
    t_s_ += kStep_s;
    const double phase = std::fmod(t_s_, 100.0);
    const double bank_rad =
        phase < 40.0 ? 0.0 : 0.25 * (1.0 - std::cos(2.0 * std::numbers::pi * (phase - 40.0) / 60.0));
    const double turn_radps = kStandardGravity_mps2 * std::tan(bank_rad) / kSpeed_mps;
    const Quat before = q_world_body_;
    yaw_rad_ += turn_radps * kStep_s;
    q_world_body_ = Eigen::AngleAxisd(yaw_rad_, Vec3::UnitZ()) * Eigen::AngleAxisd(-bank_rad, Vec3::UnitX());
    CalibratedSample s;
    s.t_ns = std::llround(1e9 * t_s_);
    s.has = kAcc | kGyr;
    s.acc_mps2 =
        array(Vec3(Vec3(0.0, 0.0, kStandardGravity_mps2 / std::cos(bank_rad)) + acc_bias_ + 0.1 * random_.normal3()));
    s.gyr_radps =
        array(Vec3(log_quat(before.conjugate() * q_world_body_) / kStep_s + gyr_bias_ + 0.002 * random_.normal3()));
    return s;
  }
  [[nodiscard]] const Quat& q_world_body() const { return q_world_body_; }

 private:
  static constexpr double kSpeed_mps = 30.0;
  sim::Stream random_;
  Vec3 gyr_bias_ = 0.01 * random_.normal3(), acc_bias_ = 0.05 * random_.normal3();
  Quat q_world_body_ = Quat::Identity();
  double t_s_ = 0.0, yaw_rad_ = 0.0;
};

TEST(Vehicle, TheAccelerationOfACirclingAircraftIsNoOffsetThatHasJumped) {
  Coverage coverage;
  double tilt2 = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Circling aircraft(seed);
    AttitudeFilter filter;
    for (int i = 0; i < 5000; ++i) {
      const AttitudeEstimate e = filter.step(aircraft.next(), false);
      const Vec3 up = quat(e.q_world_body) * (aircraft.q_world_body().conjugate() * Vec3::UnitZ());
      const double tilt = std::atan2(up.head<2>().norm(), up.z());
      coverage.note(tilt < 3.4 * std::hypot(e.sigma_roll_rad, e.sigma_pitch_rad));
      tilt2 += tilt * tilt;
    }
  }
  EXPECT_GT(coverage.share(), 0.95);                                 // 0.55 where it is called one
  EXPECT_LT(kDegPerRad * std::sqrt(tilt2 / coverage.judged), 15.0);  // and 42
}

}  // namespace
}  // namespace stillpoint::fusion

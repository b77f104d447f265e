/// Where two witnesses disagree and nobody knows which is wrong, the attitude may be off by what one of them says.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"
#include "fusion/pull.h"
#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

/// Three degrees a second about the vertical from a rest on, which a rest detector takes for an offset.
TEST(Pull, ATurntableThatIsCalledRestLeavesNoSureHeading) {
  constexpr double kTurn_radps = 0.05;
  AttitudeFilter filter;
  double turned_rad = 0.0;
  Coverage coverage;
  for (int i = 0; i < 8000; ++i) {
    const double rate = i > 1000 && i < 5000 ? kTurn_radps : 0.0;
    turned_rad += 0.01 * rate;
    const double noise = 1e-3 * ((i * 7919) % 101 / 50.0 - 1.0);
    CalibratedSample s;
    s.t_ns = 10'000'000LL * (i + 1);
    s.has = kAcc | kGyr;
    s.acc_mps2 = {noise, -noise, kStandardGravity_mps2 + noise};
    s.gyr_radps = {noise, -noise, rate + noise};
    const AttitudeEstimate e = filter.step(s, true);
    if (i < 200) continue;
    const double error =
        test::error_world(Quat(Eigen::AngleAxisd(turned_rad, Vec3::UnitZ())), quat(e.q_world_body)).z();
    coverage.note(std::abs(error) < 3.0 * e.sigma_yaw_rad);
  }
  EXPECT_GT(coverage.share(), 0.98);
}

/// (A33) What has lately been learnt of the tilt is stated in part, however much of it was expected.
TEST(Pull, WhatHasLatelyBeenLearntMayHaveBeenAVehicle) {
  constexpr double kMemory_s = 20.0, kStep_s = 0.05;
  const auto stated = [](double rad) { return 0.15 * (rad * rad - 9e-4); };          // but for a hand's 0.03 rad
  const Mat3 R = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitZ()).matrix();  // the body's x is the world's y
  Pull pull;
  pull.add(Vec3(0.029, 0.0, 0.3), Vec3::Ones());
  EXPECT_EQ(pull.unexplained_rad2().norm(), 0.0);
  pull.add(Vec3(0.171, 0.0, 0.0), Vec3::Ones());
  EXPECT_NEAR(pull.unexplained_rad2()(0, 0), stated(0.2), 1e-12);
  EXPECT_EQ(pull.unexplained_rad2()(2, 2), 0.0);
  pull.pass(Vec3(0.01, 0.0, 0.0), R, kStep_s);  // the offset of the start turns nothing
  EXPECT_NEAR(pull.unexplained_rad2()(0, 0), stated(0.2 * std::exp(-kStep_s / kMemory_s)), 1e-12);
  EXPECT_LT(pull.unexplained_rad2()(1, 1), 1e-20);
  pull.turn_world(R);
  EXPECT_NEAR(pull.unexplained_rad2()(0, 0), 0.0, 1e-12);
  EXPECT_GT(pull.unexplained_rad2()(1, 1), 0.005);

  pull.forget_tilt();
  EXPECT_EQ(pull.unexplained_rad2().norm(), 0.0);
  pull.pass(Vec3::Zero(), R, kStep_s);
  double most = 0.0;
  for (int i = 0; i < 6000; ++i) {
    pull.pass(Vec3(0.02, 0.0, 0.0), R, kStep_s);
    EXPECT_LT(pull.unexplained_rad2()(0, 0), 1e-20);
    most = std::max(most, pull.unexplained_rad2()(1, 1));
  }
  EXPECT_NEAR(most, stated(0.02 * kMemory_s / std::numbers::e),
              1e-4);  // t exp(-t / T), a step being its own mean at last
  EXPECT_EQ(pull.unexplained_rad2().norm(), 0.0);
}

}  // namespace
}  // namespace stillpoint::fusion

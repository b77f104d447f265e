/// The defining property - equation, sign, frame, unit - of the accelerometer's effects.
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

TEST(Law, AccTempLinFollowsTheTemperatureAgainst25Degrees) {
  expect_law("{effect: acc_temp_lin, k_mps2_per_K: [1, -2, 0.5]}", Sensor::kAcc,
             [](const Twins& w, std::size_t i) { return Vec3((temp_at(w.t(i)) - 25.0) * kK); });
}

TEST(Law, AccTempQuadAndScaleFollowTheTemperatureAgainst25Degrees) {
  const auto tau = [](const Twins& w, std::size_t i) { return temp_at(w.t(i)) - 25.0; };
  expect_law(
      "{effect: acc_temp_quad, k2_mps2_per_K2: [1, -2, 0.5], k1_mps2_per_K: 3}", Sensor::kAcc,
      [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * tau(w, i) * kK + 3.0 * tau(w, i) * Vec3::Ones()); });
  expect_law("{effect: acc_temp_scale, S_per_K: [1, -2, 0.5]}", Sensor::kAcc,
             [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * kK.cwiseProduct(w.force(i))); });
}

/// The loop in D(T): above nothing while it warms, below nothing while it cools.
TEST(Law, AccTempLagHasTwoBranches) {
  const auto law = [](const Twins& w, std::size_t i) { return Vec3(chamber_lag(w.t(i), 12.0) * kK); };
  expect_law("{effect: acc_temp_lag, k_mps2_per_K: [1, -2, 0.5], tau_s: 12}", Sensor::kAcc, law, 1e-5, chamber());
  const Twins twins({effect("{effect: acc_temp_lag, k_mps2_per_K: [1, -2, 0.5], tau_s: 12}")}, chamber());
  EXPECT_EQ(twins.acc(0).norm(), 0.0);
  EXPECT_GT(twins.acc(10000).x(), 1.0);  // 100 s: a quarter of the second cycle, warming
  EXPECT_LT(twins.acc(14000).x(), -1.0);
}

TEST(Law, AccQuadIsEven) {
  expect_law(
      "{effect: acc_quad, k2_per_mps2: [1, -2, 0.5]}", Sensor::kAcc,
      [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.force(i).array().square()); }, 1e-8);
}

/// Turned through all attitudes, so that every axis feels both signs.
SimulationConfig tumbling() {
  SimulationConfig c = base_config();
  c.motion->kind = "tumble";
  const Twins twins({}, c);
  for (int axis = 0; axis < 3; ++axis) {
    double low = 0.0, high = 0.0;
    for (std::size_t i = 0; i < twins.size(); ++i) {
      low = std::min(low, twins.force(i)[axis]);
      high = std::max(high, twins.force(i)[axis]);
    }
    EXPECT_TRUE(low < -5.0 && high > 5.0) << "the motion leaves one sign of axis " << axis << " out";
  }
  return c;
}

TEST(Law, AccCubicIsOddAndKeepsEachAxisToItself) {
  expect_law(
      "{effect: acc_cubic, k3_per_mps2_2: [1, -2, 0.5]}", Sensor::kAcc,
      [](const Twins& w, std::size_t i) {
        const Vec3 f = w.force(i);
        return Vec3(f.x() * f.x() * f.x(), -2.0 * f.y() * f.y() * f.y(), 0.5 * f.z() * f.z() * f.z());
      },
      1e-7, tumbling());
}

/// One number more on the positive side and the same less on the negative: never odd, never below zero for k > 0.
TEST(Law, AccAsymAddsTheSameOnBothSidesOfZero) {
  expect_law(
      "{effect: acc_asym, k: [1, -2, 0.5]}", Sensor::kAcc,
      [](const Twins& w, std::size_t i) {
        const Vec3 f = w.force(i);
        const auto one = [&](int axis, double k) { return f[axis] > 0.0 ? k * f[axis] : -k * f[axis]; };
        return Vec3(one(0, 1.0), one(1, -2.0), one(2, 0.5));
      },
      1e-9, tumbling());
}

/// Follows the discharge and, within a sample, the load; V0 = 3.7 V.
TEST(Law, AccVoltFollowsTheSupplyAgainst3V7) {
  expect_law(
      "{effect: acc_volt, k_mps2_per_V: [1, -2, 0.5]}", Sensor::kAcc,
      [](const Twins& w, std::size_t i) { return Vec3((supply_at(w.t(i)) - 3.7) * kK); }, 1e-9, discharging(),
      switched_load());
}

/// Sampled at 100 Hz a line at 170 Hz is one at -30 Hz, one at 210 Hz one at 10 Hz; at 120 Hz, 170 Hz is 50 Hz.
TEST(Law, AccAliasFoldsAboutHalfTheRate) {
  const auto turns = [](double per_row, double phase) {
    return [=](const Twins&, std::size_t i) {
      return Vec3(std::sin(2.0 * M_PI * per_row * static_cast<double>(i) + phase) * kK);
    };
  };
  expect_law("{effect: acc_alias, b_mps2: [1, -2, 0.5], f_hz: 170, phase_rad: 0.4}", Sensor::kAcc, turns(-0.3, 0.4));
  expect_law("{effect: acc_alias, b_mps2: [1, -2, 0.5], f_hz: 210}", Sensor::kAcc, turns(0.1, 0.0));
  SimulationConfig faster = base_config();
  faster.rate_hz = 120.0;
  expect_law("{effect: acc_alias, b_mps2: [1, -2, 0.5], f_hz: 170, phase_rad: 0.4}", Sensor::kAcc,
             turns(50.0 / 120.0, 0.4), 1e-9, faster);
}

TEST(Law, LeverArmHasItsEulerAndItsCentripetalPart) {
  expect_law("{effect: acc_lever, r_m: [0.1, -0.2, 0.05]}", Sensor::kAcc, [](const Twins& w, std::size_t i) {
    const MotionState s = w.motion->at(w.t(i));
    const Vec3 r(0.1, -0.2, 0.05);
    const Mat3 W = skew(s.rate_radps);
    return Vec3(skew(s.angular_acceleration_radps2) * r + W * W * r);
  });
}

/// The same from geometry: the second difference of the path of the point itself.
TEST(Law, LeverArmIsTheAccelerationOfThatPoint) {
  const Vec3 r(0.1, -0.2, 0.05);
  const Twins twins({effect("{effect: acc_lever, r_m: [0.1, -0.2, 0.05]}")});
  const auto point = [&](double t) { return Vec3(twins.motion->at(t).q_world_body * r); };
  for (std::size_t i = 100; i < twins.size(); i += 37) {
    constexpr double h = 1e-4;
    const double t = twins.t(i);
    const Vec3 a = (point(t + h) - 2.0 * point(t) + point(t - h)) / (h * h);
    ASSERT_LT((twins.acc(i) - twins.motion->at(t).q_world_body.conjugate() * a).norm(), 2e-5 * (1.0 + a.norm()));
  }
}

/// Each axis from the path of its own point; no axis hears another's point.
TEST(Law, SizeEffectIsTheAccelerationOfThreePoints) {
  const std::array<Vec3, 3> points{Vec3(0.1, -0.2, 0.05), Vec3(-0.3, 0.02, 0.1), Vec3(0.0, 0.15, -0.25)};
  const Twins twins({effect("{effect: acc_size, r_m: [[0.1, -0.2, 0.05], [-0.3, 0.02, 0.1], [0, 0.15, -0.25]]}")});
  for (std::size_t i = 100; i < twins.size(); i += 37)
    for (int axis = 0; axis < 3; ++axis) {
      const auto path = [&](double t) {
        return Vec3(twins.motion->at(t).q_world_body * points[static_cast<std::size_t>(axis)]);
      };
      constexpr double h = 1e-4;
      const double t = twins.t(i);
      const Vec3 a = (path(t + h) - 2.0 * path(t) + path(t - h)) / (h * h);
      const Vec3 in_body = twins.motion->at(t).q_world_body.conjugate() * a;
      ASSERT_NEAR(twins.acc(i)[axis], in_body[axis], 2e-5 * (1.0 + a.norm()));
    }
}

TEST(Law, SizeEffectWithOnePointIsTheLeverArm) {
  const Twins size({effect("{effect: acc_size, r_m: [[0.1, -0.2, 0.05], [0.1, -0.2, 0.05], [0.1, -0.2, 0.05]]}")});
  const Twins lever({effect("{effect: acc_lever, r_m: [0.1, -0.2, 0.05]}")});
  for (std::size_t i = 0; i < size.size(); ++i) ASSERT_LT((size.acc(i) - lever.acc(i)).norm(), 1e-12);
}

TEST(Law, AccGravityPointsUpInTheWorldAndTurnsWithTheBody) {
  expect_law("{effect: acc_gravity, dg_mps2: 0.02}", Sensor::kAcc, [](const Twins& w, std::size_t i) {
    return Vec3(w.on[i].true_q_world_body.conjugate() * Vec3(0.0, 0.0, 0.02));
  });
}

}  // namespace
}  // namespace stillpoint::sim

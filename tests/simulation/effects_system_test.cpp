/// The defining property of delays, clock faults, the bias tracker and the frame of the reference.
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

TEST(Law, DelayIsTheTruthOfEarlier) {
  for (const double tau : {0.004, 0.017}) {
    expect_law("{effect: mag_delay, tau_s: " + std::to_string(tau) + "}", Sensor::kMag,
               [&](const Twins& w, std::size_t i) {
                 const MotionState s = w.motion->at(w.t(i) - tau);
                 return Vec3(s.q_world_body.conjugate() * Vec3(0.0, 20.0, -43.0) - w.field(i));
               });
    expect_law("{effect: gyr_delay, tau_s: " + std::to_string(tau) + "}", Sensor::kGyr,
               [&](const Twins& w, std::size_t i) { return Vec3(w.motion->at(w.t(i) - tau).rate_radps - w.rate(i)); });
    expect_law("{effect: acc_delay, tau_s: " + std::to_string(tau) + "}", Sensor::kAcc,
               [&](const Twins& w, std::size_t i) {
                 const MotionState s = w.motion->at(w.t(i) - tau);
                 const Vec3 f_world = s.acceleration_mps2 + Vec3(0.0, 0.0, 9.80665);
                 return Vec3(s.q_world_body.conjugate() * f_world - w.force(i));
               });
    expect_law("{effect: sys_offset, tau_s: " + std::to_string(tau) + "}", Sensor::kGyr,
               [&](const Twins& w, std::size_t i) { return Vec3(w.motion->at(w.t(i) - tau).rate_radps - w.rate(i)); });
  }
  expect_law("{effect: sys_skew, eps_ppm: 2000}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) { return Vec3(w.motion->at(w.t(i) * 1.002).rate_radps - w.rate(i)); });
  expect_law("{effect: sys_skew, eps_ppm: -500, k_ppm_per_K: 200}", Sensor::kGyr, [](const Twins& w, std::size_t i) {
    double warmth_Ks = 0.0;
    for (std::size_t row = 0; row < i; ++row) warmth_Ks += (temp_at(w.t(row)) - 25.0) / kRate_hz;
    return Vec3(w.motion->at(w.t(i) - 500e-6 * w.t(i) + 200e-6 * warmth_Ks).rate_radps - w.rate(i));
  });
  expect_law("{effect: sys_gap, n: 3, t0_s: 20}", Sensor::kGyr, [](const Twins& w, std::size_t i) {
    return w.t(i) > 20.0 ? Vec3(w.motion->at(w.t(i) + 3.0 / kRate_hz).rate_radps - w.rate(i)) : Vec3::Zero();
  });
}

/// Axes with converters of their own: each looks back by its own time.
TEST(Law, DelayOfAnAxisIsThatAxisOfEarlier) {
  const Twins twins({effect("{effect: gyr_delay, tau_s: 0.004, axes: [x, z]}"),
                     effect("{effect: gyr_delay, tau_s: 0.013, axes: [z]}")});
  double largest = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const auto earlier = [&](double tau_s, int axis) {
      return twins.motion->at(twins.t(i) - tau_s).rate_radps[axis] - twins.rate(i)[axis];
    };
    ASSERT_NEAR(twins.gyr(i).x(), earlier(0.004, 0), 1e-12);
    ASSERT_EQ(twins.gyr(i).y(), 0.0);
    ASSERT_NEAR(twins.gyr(i).z(), earlier(0.017, 2), 1e-12);
    largest = std::max(largest, std::abs(twins.gyr(i).z()));
  }
  EXPECT_GT(largest, 0.01);
}

TEST(Law, RepeatedSamplesRepeatAllSensorsAtTheStatedRate) {
  const Twins twins({effect("{effect: sys_dup, fraction: 0.02}")});
  int repeats = 0;
  for (std::size_t i = 1; i < twins.size(); ++i) {
    if (twins.on[i].sample.acc_mps2 != twins.on[i - 1].sample.acc_mps2) continue;
    ++repeats;
    ASSERT_EQ(twins.on[i].sample.gyr_radps, twins.on[i - 1].sample.gyr_radps);
    ASSERT_EQ(twins.on[i].sample.mag_uT, twins.on[i - 1].sample.mag_uT);
  }
  EXPECT_NEAR(repeats, 120.0, 4.0 * std::sqrt(120.0));
}

TEST(Law, TrackerHidesASlowBiasAndIsBlindToTheAccelerometer) {
  const auto drift = effect("{effect: gyr_temp_lin, k_radps_per_K: 0.001}");
  SimulationConfig c = base_config();
  c.motion->duration_s = 300.0;
  const Twins open({drift}, c), hidden({drift, effect("{effect: sys_tracker, tau_s: 5}")}, c);
  double left = 0.0, without = 0.0;
  for (std::size_t i = 20000; i < open.size(); ++i) {
    if (open.on[i].moving) continue;
    left += hidden.gyr(i).norm();
    without += open.gyr(i).norm();
  }
  EXPECT_LT(left, 0.2 * without);
}

/// db/dt = (u - b) / tau at rest: of a constant bias exp(-t / tau) is left, on the axes chosen; in motion b stands
/// still.
TEST(Law, TrackerFollowsTheRestMeanWithItsTimeConstant) {
  SimulationConfig c = base_config();
  c.gyroscope->noise_sd = 0.0;
  c.environment.temperature = {.kind = "constant", .start_degC = 35.0};
  c.motion = MotionConfig{.kind = "hand", .duration_s = 40.0, .min_rest_s = 1e5, .max_rest_s = 1e5};
  c.effects = {effect("{effect: gyr_temp_lin, k_radps_per_K: 0.001}"),
               effect("{effect: sys_tracker, tau_s: 5, axes: [x, z]}")};
  const auto rows = simulate(c, 4);
  for (std::size_t i = 600; i + 500 < rows.size(); i += 50) {
    const auto &now = rows[i].sample.gyr_radps, &later = rows[i + 500].sample.gyr_radps;
    ASSERT_NEAR(later[0] / now[0], std::exp(-1.0), 0.005) << i;
    ASSERT_NEAR(later[2] / now[2], std::exp(-1.0), 0.005) << i;
    ASSERT_NEAR(now[1], 0.01, 1e-12);
  }
  const Twins hand({effect("{effect: gyr_temp_lin, k_radps_per_K: 0.001}"), effect("{effect: sys_tracker, tau_s: 5}")});
  const Twins open({effect("{effect: gyr_temp_lin, k_radps_per_K: 0.001}")});
  int inside = 0;
  for (std::size_t i = 200; i < hand.size(); ++i) {
    bool bout = true;  // a second after its start: the short means have left the rest behind
    for (std::size_t k = i - 100; k <= i; ++k) bout = bout && hand.on[k].moving && hand.rate(k).norm() > 0.3;
    if (!bout) continue;
    const Vec3 now = hand.gyr(i) - open.gyr(i), before = hand.gyr(i - 1) - open.gyr(i - 1);
    ASSERT_LT((now - before).norm(), 1e-12) << i;
    ++inside;
  }
  EXPECT_GT(inside, 200);
}

TEST(Law, JitterGrowsWithTheMotionAndVanishesAtRest) {
  const Twins twins({effect("{effect: sys_jitter, sd_s: 0.001}")});
  double still = 0.0, ratio = 0.0, angular = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const MotionState s = twins.motion->at(twins.t(i));
    if (!s.moving && !twins.motion->at(twins.t(i) + 0.01).moving &&
        !twins.motion->at(std::max(0.0, twins.t(i) - 0.01)).moving)
      still = std::max(still, twins.gyr(i).norm());
    ratio += twins.gyr(i).squaredNorm();
    angular += s.angular_acceleration_radps2.squaredNorm();
  }
  EXPECT_EQ(still, 0.0);
  EXPECT_NEAR(std::sqrt(ratio / angular), 0.001, 1e-4);
}

TEST(Law, PivotOffsetOfTheReferenceIsALeverArm) {
  expect_law("{effect: ref_frame, phi_rad: 0, r_m: [0.1, -0.2, 0.05]}", Sensor::kAcc,
             [](const Twins& w, std::size_t i) {
               const MotionState s = w.motion->at(w.t(i));
               const Vec3 r(0.1, -0.2, 0.05), velocity = s.rate_radps.cross(r);
               return Vec3(s.angular_acceleration_radps2.cross(r) + s.rate_radps.cross(velocity));
             });
}

TEST(Law, MountRotationIsCommonToAllSensors) {
  const Twins twins({effect("{effect: ref_frame, phi_rad: [0.02, -0.03, 0.05]}")});
  const Mat3 C = exp_so3(Vec3(0.02, -0.03, 0.05)).transpose();
  for (std::size_t i = 0; i < twins.size(); i += 11) {
    ASSERT_LT((twins.acc(i) - (C * twins.force(i) - twins.force(i))).norm(), 1e-9);
    ASSERT_LT((twins.gyr(i) - (C * twins.rate(i) - twins.rate(i))).norm(), 1e-9);
    ASSERT_LT((twins.mag(i) - (C * twins.field(i) - twins.field(i))).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace stillpoint::sim

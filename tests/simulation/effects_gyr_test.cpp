/// The defining property - equation, sign, frame, unit - of the gyroscope's effects.
#include "tests/simulation/effect_twins.h"

namespace stillpoint::sim {
namespace {

TEST(Law, GyrTempQuadFollowsTheTemperatureAgainst25Degrees) {
  expect_law("{effect: gyr_temp_quad, k2_radps_per_K2: [1, -2, 0.5], k1_radps_per_K: 3}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) {
               const double tau = temp_at(w.t(i)) - 25.0;
               return Vec3(tau * tau * kK + 3.0 * tau * Vec3::Ones());
             });
}

TEST(Law, GyrTempLinAndScaleFollowTheTemperatureAgainst25Degrees) {
  const auto tau = [](const Twins& w, std::size_t i) { return temp_at(w.t(i)) - 25.0; };
  expect_law("{effect: gyr_temp_lin, k_radps_per_K: [1, -2, 0.5]}", Sensor::kGyr,
             [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * kK); });
  expect_law("{effect: gyr_temp_scale, S_per_K: [1, -2, 0.5]}", Sensor::kGyr,
             [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * kK.cwiseProduct(w.rate(i))); });
}

TEST(Law, NonlinearitiesOfTheGyroscope) {
  expect_law("{effect: gyr_cubic, k3_per_radps_2: [1, -2, 0.5]}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.rate(i).array().cube()); });
  expect_law("{effect: gyr_asym, k: [1, -2, 0.5]}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.rate(i).array().abs()); });
  expect_law(
      "{effect: gyr_gsens, G_radps_per_mps2: [[0, 1, 0], [0, 0, 2], [3, 0, 0]]}", Sensor::kGyr,
      [](const Twins& w, std::size_t i) { return Vec3(w.force(i).y(), 2 * w.force(i).z(), 3 * w.force(i).x()); });
}

TEST(Law, GyrVoltFollowsTheSupplyAgainst3V7) {
  expect_law(
      "{effect: gyr_volt, k_radps_per_V: [1, -2, 0.5]}", Sensor::kGyr,
      [](const Twins& w, std::size_t i) { return Vec3((supply_at(w.t(i)) - 3.7) * kK); }, 1e-9, discharging(),
      switched_load());
}

/// Sampled at 100 Hz a line at 130 Hz is one at 30 Hz; close to a multiple, at 200.05 Hz, a slow drift.
TEST(Law, GyrAliasFoldsAboutHalfTheRate) {
  const auto turns = [](double per_row, double phase) {
    return [=](const Twins&, std::size_t i) {
      return Vec3(std::sin(2.0 * M_PI * per_row * static_cast<double>(i) + phase) * kK);
    };
  };
  expect_law("{effect: gyr_alias, b_radps: [1, -2, 0.5], f_hz: 130, phase_rad: -1.1}", Sensor::kGyr, turns(0.3, -1.1));
  expect_law("{effect: gyr_alias, b_radps: [1, -2, 0.5], f_hz: 200.05}", Sensor::kGyr, turns(0.0005, 0.0));
}

/// The mean turns as a body does whose three angles oscillate so: its small turns put one after the other over a cycle
/// (no formula for coning used). About the mean stands the rate of the oscillation itself, and nothing else.
TEST(Law, GyrConingIsWhatACycleOfSmallTurnsLeaves) {
  const Vec3 a(2e-4, -1e-4, 1.5e-4), phase(0.3, 1.2, 2.9);
  constexpr double kFrequency_hz = 20.0, kOmega = 2.0 * M_PI * kFrequency_hz;
  const auto angle_rate = [&](double t) { return Vec3(kOmega * a.array() * (kOmega * t + phase.array()).cos()); };
  constexpr int kSteps = 4000;
  Mat3 turned = Mat3::Identity();
  for (int k = 0; k < kSteps; ++k)
    turned *= exp_so3(angle_rate((k + 0.5) / kSteps / kFrequency_hz) / (kSteps * kFrequency_hz));
  const Vec3 left =
      kFrequency_hz * 0.5 * Vec3(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0), turned(1, 0) - turned(0, 1));
  const Twins twins({effect("{effect: gyr_coning, a_rad: [2e-4, -1e-4, 1.5e-4], f_hz: 20, p_rad: [0.3, 1.2, 2.9]}")});
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < twins.size(); ++i) {
    mean += twins.gyr(i) / static_cast<double>(twins.size());  // 5 rows a cycle: the oscillation has no mean
    ASSERT_LT((twins.gyr(i) - angle_rate(twins.t(i)) - left).norm(), 2e-3 * left.norm());
  }
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(mean[axis], left[axis], 2e-3 * left.norm());
  EXPECT_GT(left.cwiseAbs().minCoeff(), 0.1 * left.norm()) << "an axis without coning tests nothing";
}

TEST(Law, GyrEarthTurnsWithTheBody) {
  expect_law(
      "{effect: gyr_earth}", Sensor::kGyr,
      [](const Twins& w, std::size_t i) {
        return Vec3(w.on[i].true_q_world_body.conjugate() * (7.292115e-5 * Vec3(0.0, std::cos(0.85), std::sin(0.85))));
      },
      1e-12);
}

TEST(Law, GyrEarthHasTheMeasuredDirectionInAWorldThatDoesNotLookNorth) {
  expect_law(
      "{effect: gyr_earth, w_radps: [5e-5, -2e-5, 4e-5]}", Sensor::kGyr,
      [](const Twins& w, std::size_t i) {
        return Vec3(w.on[i].true_q_world_body.conjugate() * Vec3(5e-5, -2e-5, 4e-5));
      },
      1e-12);
}

/// First-order lag: to second order in tau it is a delay by tau, less the amplitude it takes away.
TEST(Law, LowPassLosesAmplitudeAndDelays) {
  expect_law(
      "{effect: gyr_lpf, tau_s: 0.002}", Sensor::kGyr,
      [](const Twins& w, std::size_t i) {
        // Direct quadrature of the impulse response over 20 tau.
        Vec3 sum = Vec3::Zero();
        constexpr int kSteps = 400;
        constexpr double kTau = 0.002, kLength = 20.0 * kTau;
        for (int k = 0; k <= kSteps; ++k) {
          const double s = kLength * k / kSteps;
          const double simpson = k == 0 || k == kSteps ? 1.0 : k % 2 == 1 ? 4.0 : 2.0;
          sum += simpson * std::exp(-s / kTau) / kTau * w.motion->at(std::max(0.0, w.t(i) - s)).rate_radps;
        }
        return Vec3(sum * kLength / kSteps / 3.0 - w.rate(i));
      },
      5e-4);  // the input is taken as straight over 2.5 ms
}

TEST(Law, ThermalLagDiesOutWhenTheTemperatureStands) {
  SimulationConfig c = base_config();
  c.motion->duration_s = 600.0;
  const Twins twins({effect("{effect: gyr_temp_lag, k_radps_per_K: 0.01, tau_s: 20}")}, c);
  // T = 25 + 8 (1 - exp(-t/60)), T_L from its equation: T - T_L = 8 tau/(60 - tau) (exp(-t/60) - exp(-t/tau)).
  for (std::size_t i = 0; i < twins.size(); i += 97) {
    const double t = twins.t(i), lag = 8.0 * 20.0 / 40.0 * (std::exp(-t / 60.0) - std::exp(-t / 20.0));
    ASSERT_NEAR(twins.gyr(i).x(), 0.01 * lag, 1e-6);
  }
}

}  // namespace
}  // namespace stillpoint::sim

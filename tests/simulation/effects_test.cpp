/// For every effect of the catalogue its defining property - equation, sign, frame, unit - and what it must not do.
/// Twins share every random number, so the difference of two runs is the effect alone.
#include <gmock/gmock.h>

#include <functional>

#include "core/so3.h"
#include "io/simulation_yaml.h"
#include "simulation/effect_catalogue.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {
namespace {

constexpr double kRate_hz = 100.0;

SimulationConfig base_config() {
  SimulationConfig c;
  c.rate_hz = kRate_hz;
  c.accelerometer = TriadConfig{.noise_sd = 0.02};
  c.gyroscope = TriadConfig{.noise_sd = 0.001};
  c.magnetometer = TriadConfig{.noise_sd = 0.3};
  c.motion = MotionConfig{.kind = "hand", .duration_s = 60.0};
  c.environment.current.kind = "steps";
  return c;
}

EffectConfig effect(const std::string& yaml) {
  io::YamlFaults faults("test");
  EffectConfig out;
  io::read_effect(YAML::Load(yaml), out, faults);
  EXPECT_TRUE(faults.empty()) << ::testing::PrintToString(faults.messages());
  return out;
}

/// An effect of the given ID, each number at the upper end of its usual range.
EffectConfig typical(const EffectInfo& info) {
  EffectConfig e;
  e.id = info.id;
  for (const auto& p : info.parameters) {
    if (!p.required) continue;
    double value = p.typical_high > 0.0 ? p.typical_high : 20.0;
    if (p.key == "n") value = 3.0;
    if (p.key == "f_hz") value = 20.0;
    if (info.id == "acc_sat") value = 4.0;
    if (info.id == "gyr_sat") value = 1.0;
    if (info.id == "mag_sat") value = 30.0;
    e.parameters[p.key].assign(static_cast<std::size_t>(p.count), value);
  }
  if (info.id == "mag_soft_step") e.parameters["M"] = {0.1, 0, 0, 0, -0.05, 0.02, 0, 0, 0.03};
  if (info.id == "gyr_coning") e.parameters["p_rad"] = {0.0, 1.0, 2.5};
  return e;
}

/// Rows with the effects on and off.
struct Twins {
  std::vector<SimulatedSample> on, off;
  std::shared_ptr<const Motion> motion;

  explicit Twins(const std::vector<EffectConfig>& effects, SimulationConfig c = base_config(), std::uint64_t seed = 4) {
    motion = make_motion(*c.motion, seed);
    off = simulate(c, motion, seed);
    c.effects = effects;
    on = simulate(c, motion, seed);
  }
  [[nodiscard]] std::size_t size() const { return on.size(); }
  [[nodiscard]] double t(std::size_t i) const { return 1e-9 * static_cast<double>(on[i].sample.t_ns); }
  [[nodiscard]] Vec3 acc(std::size_t i) const { return vec(on[i].sample.acc_mps2) - vec(off[i].sample.acc_mps2); }
  [[nodiscard]] Vec3 gyr(std::size_t i) const { return vec(on[i].sample.gyr_radps) - vec(off[i].sample.gyr_radps); }
  [[nodiscard]] Vec3 mag(std::size_t i) const { return vec(on[i].sample.mag_uT) - vec(off[i].sample.mag_uT); }
  [[nodiscard]] Vec3 force(std::size_t i) const { return vec(on[i].true_acc_mps2); }
  [[nodiscard]] Vec3 rate(std::size_t i) const { return vec(on[i].true_gyr_radps); }
  [[nodiscard]] Vec3 field(std::size_t i) const { return vec(on[i].true_mag_uT); }
  [[nodiscard]] Vec3 change(Sensor s, std::size_t i) const {
    return s == Sensor::kAcc ? acc(i) : s == Sensor::kGyr ? gyr(i) : mag(i);
  }
};

/// Surroundings without thermometer noise: the warm-up of the default configuration.
double temp_at(double t_s) { return 25.0 + 8.0 * (1.0 - std::exp(-t_s / 60.0)); }

class EveryEffect : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryEffect, ChangesItsOwnSensorAndNoOther) {
  const EffectInfo& info = *find_effect(GetParam());
  SimulationConfig c = base_config();
  if (info.id.ends_with("_vre")) c.motion->kind = "drone";
  const Twins twins({typical(info)}, c);
  double acc = 0.0, gyr = 0.0, mag = 0.0, reference = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    acc += twins.acc(i).norm();
    gyr += twins.gyr(i).norm();
    mag += twins.mag(i).norm();
    reference += twins.on[i].ref_q_world_body.angularDistance(twins.off[i].ref_q_world_body);
    ASSERT_TRUE(vec(twins.on[i].sample.acc_mps2).allFinite() && vec(twins.on[i].sample.gyr_radps).allFinite());
  }
  const bool all = (info.sensor == "sys" && info.id != "sys_tracker") || info.id == "ref_frame";
  EXPECT_EQ(acc > 0.0, all || info.sensor == "acc");
  EXPECT_EQ(gyr > 0.0, all || info.sensor == "gyr" || info.id == "sys_tracker");
  EXPECT_EQ(mag > 0.0, all || info.sensor == "mag");
  EXPECT_EQ(reference > 1e-6, info.id == "ref_error");
}

class EveryTriadEffect : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryTriadEffect, KeepsToItsAxesAndItsWindow) {
  const EffectInfo& info = *find_effect(GetParam());
  EffectConfig e = typical(info);
  e.axes = {1};
  e.window_s = {25.0, 40.0};
  SimulationConfig c = base_config();
  if (info.id.ends_with("_vre")) c.motion->kind = "drone";
  const Twins twins({e}, c);
  const Sensor sensor = info.sensor == "acc" ? Sensor::kAcc : info.sensor == "gyr" ? Sensor::kGyr : Sensor::kMag;
  const bool delays = info.id.ends_with("_delay");  // a delay moves one sensor as a whole, whatever the axis
  double inside = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const Vec3 d = twins.change(sensor, i);
    const bool outside = twins.t(i) < 24.9 || twins.t(i) > 40.1;
    ASSERT_TRUE(!outside || d.norm() == 0.0) << twins.t(i);
    ASSERT_TRUE(delays || (d.x() == 0.0 && d.z() == 0.0)) << twins.t(i);
    inside += std::abs(d.y());
  }
  EXPECT_GT(inside, 0.0);
}

std::vector<std::string> ids(bool of_one_triad) {
  std::vector<std::string> out;
  for (const auto& e : effect_catalogue())
    if (!of_one_triad || (e.sensor != "sys" && e.sensor != "ref")) out.push_back(e.id);
  return out;
}
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, ::testing::ValuesIn(ids(false)),
                         [](const auto& i) { return i.param; });
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryTriadEffect, ::testing::ValuesIn(ids(true)),
                         [](const auto& i) { return i.param; });

/// The effect's change at every row against its equation, written here again from the catalogue.
void expect_law(const std::string& yaml, Sensor sensor, const std::function<Vec3(const Twins&, std::size_t)>& law,
                double tolerance = 1e-9) {
  const Twins twins({effect(yaml)});
  double largest = 0.0;
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const Vec3 expected = law(twins, i);
    largest = std::max(largest, expected.norm());
    ASSERT_LT((twins.change(sensor, i) - expected).norm(), tolerance) << yaml << " at " << twins.t(i) << " s";
  }
  EXPECT_GT(largest, 100.0 * tolerance) << "the law was never excited";
}

const Vec3 kK(1.0, -2.0, 0.5);

TEST(Law, TemperatureOffsetsFollowTheTemperatureAgainst25Degrees) {
  const auto tau = [](const Twins& w, std::size_t i) { return temp_at(w.t(i)) - 25.0; };
  expect_law("{effect: acc_temp_lin, k_mps2_per_K: [1, -2, 0.5]}", Sensor::kAcc,
             [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * kK); });
  expect_law(
      "{effect: gyr_temp_quad, k2_radps_per_K2: [1, -2, 0.5], k1_radps_per_K: 3}", Sensor::kGyr,
      [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * tau(w, i) * kK + 3.0 * tau(w, i) * Vec3::Ones()); });
  expect_law("{effect: mag_temp_scale, S_per_K: [1, -2, 0.5]}", Sensor::kMag,
             [&](const Twins& w, std::size_t i) { return Vec3(tau(w, i) * kK.cwiseProduct(w.field(i))); });
}

TEST(Law, NonlinearitiesOfTheElement) {
  expect_law(
      "{effect: acc_quad, k2_per_mps2: [1, -2, 0.5]}", Sensor::kAcc,
      [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.force(i).array().square()); }, 1e-8);
  expect_law("{effect: gyr_cubic, k3_per_radps_2: [1, -2, 0.5]}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.rate(i).array().cube()); });
  expect_law("{effect: gyr_asym, k: [1, -2, 0.5]}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) { return Vec3(kK.array() * w.rate(i).array().abs()); });
  expect_law(
      "{effect: gyr_gsens, G_radps_per_mps2: [[0, 1, 0], [0, 0, 2], [3, 0, 0]]}", Sensor::kGyr,
      [](const Twins& w, std::size_t i) { return Vec3(w.force(i).y(), 2 * w.force(i).z(), 3 * w.force(i).x()); });
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

TEST(Law, SizeEffectWithOnePointIsTheLeverArm) {
  const Twins size({effect("{effect: acc_size, r_m: [[0.1, -0.2, 0.05], [0.1, -0.2, 0.05], [0.1, -0.2, 0.05]]}")});
  const Twins lever({effect("{effect: acc_lever, r_m: [0.1, -0.2, 0.05]}")});
  for (std::size_t i = 0; i < size.size(); ++i) ASSERT_LT((size.acc(i) - lever.acc(i)).norm(), 1e-12);
}

TEST(Law, WhatIsFixedInTheWorldTurnsWithTheBody) {
  const auto in_body = [](const Twins& w, std::size_t i, const Vec3& v) {
    return Vec3(w.on[i].true_q_world_body.conjugate() * v);
  };
  expect_law("{effect: mag_field_step, b_world_uT: [5, 0, -3], t0_s: 20}", Sensor::kMag,
             [&](const Twins& w, std::size_t i) {
               return w.t(i) > 20.0 ? in_body(w, i, {5, 0, -3}) : Vec3::Zero();
             });
  expect_law("{effect: mag_gradient, G_uT_per_m: [[1, 2, 3], [2, 4, 5], [3, 5, -5]]}", Sensor::kMag,
             [&](const Twins& w, std::size_t i) {
               const Vec3 p = w.on[i].true_position_m;
               return in_body(w, i,
                              {p.x() + 2 * p.y() + 3 * p.z(), 2 * p.x() + 4 * p.y() + 5 * p.z(),
                               3 * p.x() + 5 * p.y() - 5 * p.z()});
             });
  expect_law("{effect: acc_gravity, dg_mps2: 0.02}", Sensor::kAcc, [&](const Twins& w, std::size_t i) {
    return in_body(w, i, {0, 0, 0.02});
  });
  expect_law(
      "{effect: gyr_earth}", Sensor::kGyr,
      [&](const Twins& w, std::size_t i) {
        return in_body(w, i, 7.292115e-5 * Vec3(0.0, std::cos(0.85), std::sin(0.85)));
      },
      1e-12);
}

TEST(Law, WhatIsFixedInTheBodyDoesNot) {
  expect_law("{effect: mag_hard_step, b_uT: [1, -2, 0.5], t0_s: 20}", Sensor::kMag,
             [](const Twins& w, std::size_t i) { return w.t(i) > 20.0 ? kK : Vec3::Zero(); });
  expect_law("{effect: mag_flip, b_uT: [1, -2, 0.5]}", Sensor::kMag,
             [](const Twins&, std::size_t i) { return i % 2 == 0 ? kK : Vec3(-kK); });
}

TEST(Law, DelayIsTheTruthOfEarlier) {
  for (const double tau : {0.004, 0.017}) {
    expect_law("{effect: mag_delay, tau_s: " + std::to_string(tau) + "}", Sensor::kMag,
               [&](const Twins& w, std::size_t i) {
                 const MotionState s = w.motion->at(w.t(i) - tau);
                 return Vec3(s.q_world_body.conjugate() * Vec3(0.0, 20.0, -43.0) - w.field(i));
               });
    expect_law("{effect: sys_offset, tau_s: " + std::to_string(tau) + "}", Sensor::kGyr,
               [&](const Twins& w, std::size_t i) { return Vec3(w.motion->at(w.t(i) - tau).rate_radps - w.rate(i)); });
  }
  expect_law("{effect: sys_skew, eps_ppm: 2000}", Sensor::kGyr,
             [](const Twins& w, std::size_t i) { return Vec3(w.motion->at(w.t(i) * 1.002).rate_radps - w.rate(i)); });
  expect_law("{effect: sys_gap, n: 3, t0_s: 20}", Sensor::kGyr, [](const Twins& w, std::size_t i) {
    return w.t(i) > 20.0 ? Vec3(w.motion->at(w.t(i) + 3.0 / kRate_hz).rate_radps - w.rate(i)) : Vec3::Zero();
  });
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

TEST(Law, ResonanceAmplifiesBelowItsFrequencyAndRings) {
  SimulationConfig c = base_config();
  c.motion->kind = "drone";
  c.motion->vibration_hz = 30.0;
  const Twins twins({effect("{effect: acc_resonance, f_hz: 40, zeta: 0.05}")}, c);
  double before = 0.0, after = 0.0;
  for (std::size_t i = 2000; i < 4000; ++i) {
    const double truth = twins.force(i).x(), with = truth + twins.acc(i).x();  // shakes at 30 Hz
    before += truth * truth;
    after += with * with;
  }
  EXPECT_GT(after, 1.2 * before);
}

TEST(Law, QuantisationPutsReadingsOnALattice) {
  const Twins twins({effect("{effect: gyr_quant, q_radps: 0.01}")});
  for (std::size_t i = 0; i < twins.size(); ++i) {
    const double x = twins.on[i].sample.gyr_radps[1] / 0.01;
    ASSERT_NEAR(x, std::round(x), 1e-9);
    ASSERT_LE(std::abs(twins.gyr(i).y()), 0.005 + 1e-12);
  }
}

TEST(Law, SaturationPilesUpAtTheRailAndHidesBehindAFilter) {
  const std::string open = "{effect: gyr_sat, L_radps: 0.8}", hidden = "{effect: gyr_sat, L_radps: 0.8, hidden: 1}";
  const auto pile = [](const Twins& w) {
    return std::count_if(w.on.begin(), w.on.end(),
                         [](const auto& r) { return std::abs(r.sample.gyr_radps[0]) == 0.8; });
  };
  const Twins plain({effect(open)});
  EXPECT_GT(pile(plain), 50);
  for (const auto& row : plain.on) ASSERT_LE(std::abs(row.sample.gyr_radps[0]), 0.8);
  EXPECT_EQ(pile(Twins({effect(hidden), effect("{effect: gyr_lpf, tau_s: 0.005}")})), 0);
}

TEST(Law, StaleHoldRepeatsExactlyEveryNth) {
  const Twins twins({effect("{effect: mag_hold, n: 4}")});
  for (std::size_t i = 0; i < twins.size(); ++i) {
    ASSERT_EQ(twins.on[i].sample.mag_uT, twins.off[i - i % 4].sample.mag_uT);
    ASSERT_EQ(twins.acc(i).norm(), 0.0);
  }
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

TEST(Law, DeadZoneIsExactlyZero) {
  const Twins twins({effect("{effect: gyr_deadzone, d_radps: 0.01}")});
  int zeros = 0;
  for (const auto& row : twins.on) {
    ASSERT_TRUE(row.sample.gyr_radps[2] == 0.0 || std::abs(row.sample.gyr_radps[2]) >= 0.01);
    zeros += row.sample.gyr_radps[2] == 0.0 ? 1 : 0;
  }
  EXPECT_GT(zeros, 1000);
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

TEST(Law, RectificationComesAndGoesWithTheVibration) {
  SimulationConfig c = base_config();
  c.motion = MotionConfig{
      .kind = "drone", .duration_s = 60.0, .max_rest_s = 10.0, .vibration_hz = 37.0, .vibration_mps2 = 4.0};
  const Twins twins({effect("{effect: gyr_vre, k_radps_per_mps2_2: 0.001}")}, c);
  EXPECT_LT(twins.gyr(800).norm(), 1e-6);  // before the start nothing vibrates
  double mean = 0.0;
  for (std::size_t i = 2500; i < 3500; ++i) mean += (twins.gyr(i).x() + twins.gyr(i).y()) / 1000.0;
  EXPECT_NEAR(mean, 0.016, 0.1 * 0.016);  // <f^2> of a sine of 4 m/s^2 is 8, in x and in y, whatever the yaw
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

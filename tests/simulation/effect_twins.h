/// What the tests of the effects share: recordings with and without an effect, and its law written a second time.
/// Twins share every random number, so the difference of two runs is the effect alone.
#pragma once
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>

#include "core/so3.h"
#include "core/units.h"
#include "io/simulation_yaml.h"
#include "simulation/effect_catalogue.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {

inline constexpr double kRate_hz = 100.0;
inline const Vec3 kK(1.0, -2.0, 0.5);

inline SimulationConfig base_config() {
  SimulationConfig c;
  c.rate_hz = kRate_hz;
  c.accelerometer = TriadConfig{.noise_sd = 0.02};
  c.gyroscope = TriadConfig{.noise_sd = 0.001};
  c.magnetometer = TriadConfig{.noise_sd = 0.3};
  c.motion = MotionConfig{.kind = "hand", .duration_s = 60.0};
  c.environment.current.kind = "steps";
  return c;
}

inline EffectConfig effect(const std::string& yaml) {
  io::YamlFaults faults("test");
  EffectConfig out;
  io::read_effect(YAML::Load(yaml), out, faults);
  EXPECT_TRUE(faults.empty()) << ::testing::PrintToString(faults.messages());
  return out;
}

/// Rows with the effects on and off; what differs in u = H (y - B) is D, in the sensor frame.
struct Twins {
  std::vector<SimulatedSample> on, off;
  std::shared_ptr<const Motion> motion;
  std::array<Mat3, 3> matrix;  ///< H of acc, gyr, mag

  explicit Twins(const std::vector<EffectConfig>& effects, SimulationConfig c = base_config(), std::uint64_t seed = 4,
                 const RecordedEnvironment& recorded = {})
      : motion(make_motion(*c.motion, seed)),
        matrix{c.accelerometer->matrix, c.gyroscope->matrix, c.magnetometer->matrix} {
    off = simulate(c, motion, seed, recorded);
    c.effects = effects;
    on = simulate(c, motion, seed, recorded);
  }
  [[nodiscard]] std::size_t size() const { return on.size(); }
  [[nodiscard]] double t(std::size_t i) const { return in_seconds(on[i].sample.t_ns); }
  [[nodiscard]] Vec3 acc(std::size_t i) const {
    return matrix[0] * (vec(on[i].sample.acc_mps2) - vec(off[i].sample.acc_mps2));
  }
  [[nodiscard]] Vec3 gyr(std::size_t i) const {
    return matrix[1] * (vec(on[i].sample.gyr_radps) - vec(off[i].sample.gyr_radps));
  }
  [[nodiscard]] Vec3 mag(std::size_t i) const {
    return matrix[2] * (vec(on[i].sample.mag_uT) - vec(off[i].sample.mag_uT));
  }
  [[nodiscard]] Vec3 force(std::size_t i) const { return vec(on[i].true_acc_mps2); }
  [[nodiscard]] Vec3 rate(std::size_t i) const { return vec(on[i].true_gyr_radps); }
  [[nodiscard]] Vec3 field(std::size_t i) const { return vec(on[i].true_mag_uT); }
  [[nodiscard]] Vec3 change(Sensor s, std::size_t i) const {
    return s == Sensor::kAcc ? acc(i) : s == Sensor::kGyr ? gyr(i) : mag(i);
  }
};

/// Surroundings without thermometer noise: the warm-up of the default configuration.
inline double temp_at(double t_s) { return 25.0 + 8.0 * (1.0 - std::exp(-t_s / 60.0)); }

using SecondLaw = std::function<Vec3(const Twins&, std::size_t)>;

/// The effect's change at every row against its equation, written here again from the catalogue. Once with H = 1 and
/// B = 0 and once with others: D belongs to the true vector, in physical units, whatever the sensor's own numbers are.
inline void expect_law(const std::string& yaml, Sensor sensor, const SecondLaw& law, double tolerance = 1e-9,
                       SimulationConfig c = base_config(), const RecordedEnvironment& recorded = {}) {
  for (const bool plain : {true, false}) {
    if (!plain)
      for (auto* triad : {&c.accelerometer, &c.gyroscope, &c.magnetometer}) {
        (*triad)->bias = Vec3(0.3, -0.2, 0.7);
        (*triad)->matrix << 1.2, 0.1, -0.2, 0.05, 0.8, 0.15, -0.1, 0.2, 1.1;
      }
    const Twins twins({effect(yaml)}, c, 4, recorded);
    double largest = 0.0;
    for (std::size_t i = 0; i < twins.size(); ++i) {
      const Vec3 expected = law(twins, i);
      largest = std::max(largest, expected.norm());
      ASSERT_LT((twins.change(sensor, i) - expected).norm(), tolerance) << yaml << " at " << twins.t(i) << " s";
    }
    EXPECT_GT(largest, 100.0 * tolerance) << "the law was never excited";
  }
}

/// A load switched between two samples, so that no row stands on the switching itself.
inline double load_at(double t_s) { return t_s < 10.005 ? 0.0 : t_s < 35.005 ? 2.0 : -0.5; }
inline RecordedEnvironment switched_load() {
  RecordedEnvironment out;
  out.current_A = {.t_s = {0.0, 10.005, 35.005}, .value = {0.0, 2.0, -0.5}, .steps = true};
  return out;
}

/// A supply that discharges through 3.7 V, with that load on it.
inline double supply_at(double t_s) { return 3.72 - 0.001 * t_s - 0.05 * load_at(t_s); }
inline SimulationConfig discharging() {
  SimulationConfig c = base_config();
  c.environment.supply.start_V = 3.72;
  c.environment.supply.discharge_V_per_s = 0.001;
  c.environment.supply.resistance_ohm = 0.05;
  return c;
}

/// A chamber that warms and cools: T - 25 = 5 (1 - cos w t), and T - T_L from tau dT_L/dt = T - T_L, T_L(0) = T(0).
inline SimulationConfig chamber() {
  SimulationConfig c = base_config();
  c.motion->duration_s = 200.0;
  c.environment.temperature = {.kind = "chamber", .start_degC = 25.0, .rise_K = 10.0, .period_s = 80.0};
  return c;
}
inline double chamber_lag(double t_s, double tau_s) {
  const double w = 2.0 * M_PI / 80.0, x = w * tau_s;
  return 5.0 * (x * std::sin(w * t_s) - x * x * std::cos(w * t_s) + x * x * std::exp(-t_s / tau_s)) / (1.0 + x * x);
}

}  // namespace stillpoint::sim

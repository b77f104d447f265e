/// Recordings of our own simulator for the tests of the diagnosis: a hand that moves and rests, with known physics.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/so3.h"
#include "diagnosis/diagnose.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"

namespace stillpoint::diag::test {

using Parameters = std::map<std::string, std::vector<double>>;

/// Three sensors that are right but for their noise.
inline sim::SimulationConfig sensors() {
  sim::SimulationConfig s;
  s.accelerometer = sim::TriadConfig{.noise_sd = 0.02};
  s.gyroscope = sim::TriadConfig{.noise_sd = 0.001};
  s.magnetometer = sim::TriadConfig{.noise_sd = 0.3};
  return s;
}

/// `reference`: exact, mocap or none.
inline sim::SimulationConfig baseline(const std::string& reference, double duration_s = 100.0) {
  sim::SimulationConfig s = sensors();
  s.rate_hz = 50;
  s.gyroscope->bias = Vec3(0.01, -0.004, 0.002);
  s.magnetometer->bias = Vec3(3, -5, 2);
  s.motion = sim::MotionConfig{};
  s.motion->duration_s = duration_s;
  s.reference.kind = reference;
  return s;
}

/// Beside a camera of which little hides a good gyroscope.
inline sim::SimulationConfig beside_a_good_camera() {
  auto s = baseline("mocap");
  s.gyroscope->noise_sd = 1.5e-4, s.magnetometer->noise_sd = 1.0;
  s.reference.orientation_sd_rad = 3e-4, s.reference.position_sd_m = 1e-4;
  return s;
}

/// A simulation as users write it.
inline sim::SimulationConfig parsed(const std::string& yaml) {
  const auto config = io::parse_simulation(yaml, "sim.yaml");
  EXPECT_TRUE(config) << (config ? "" : config.error().message);
  return config.value_or(sim::SimulationConfig{});
}

/// A minute of a hand beside an exact reference, with entries of `effects:` as users write them.
inline sim::SimulationConfig with_law(const std::string& effects, const std::string& gyr_noise_radps = "0.0005") {
  return parsed("rate_hz: 50\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: " + gyr_noise_radps +
                "}\nmagnetometer: {noise_uT: 0.2}\nmotion: {kind: hand, duration_s: 60}\n"
                "environment: {temperature: {kind: warm_up, rise_K: 15}, current: {kind: steps}}\neffects:\n" +
                effects);
}

/// A recording without a reference, over 15 K; `surroundings`: further entries of `environment:`.
inline sim::SimulationConfig without_reference(const std::string& motion, const std::string& effects = "[]",
                                               const std::string& surroundings = "") {
  return parsed(
      "rate_hz: 100\naccelerometer: {noise_mps2: 0.005}\ngyroscope: {noise_radps: 0.0005}\n"
      "magnetometer: {noise_uT: 0.2}\nreference: {kind: none}\n"
      "environment: {temperature: {kind: warm_up, rise_K: 15}" +
      surroundings + "}\nmotion: " + motion + "\neffects: " + effects + "\n");
}

/// The recording of `config` with one effect more; none when `id` is empty.
inline io::Recording record(sim::SimulationConfig config, const std::string& id, const Parameters& parameters,
                            std::uint64_t seed) {
  if (!id.empty()) config.effects.push_back({.id = id, .parameters = parameters, .axes = {}, .window_s = {}});
  return io::to_recording(sim::simulate(config, seed));
}

/// The reference turned by at(seconds from the start), rad: markers on the body, or a camera in the world.
template <class Turn>
void turn_reference(io::Recording& r, const Turn& at, bool in_world = false) {
  for (std::size_t i = 0; i < r.size(); ++i) {
    const auto& x = r.ref_q_world_body[i];
    const Quat q(x[0], x[1], x[2], x[3]), turn = exp_quat(at(r.t_s(i) - r.t_s(0)));
    const Quat turned = in_world ? turn * q : q * turn;
    r.ref_q_world_body[i] = Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z());
  }
}

/// Of this effect; null where it was not found.
inline const Finding* finding(const Diagnosis& diagnosis, const std::string& id) {
  for (const Finding& f : diagnosis.findings)
    if (f.effect == id) return &f;
  return nullptr;
}
inline const Finding* finding(const Answer& answer, const std::string& id) { return finding(answer.diagnosis, id); }

/// A number of it.
inline const Parameter& parameter(const Finding& f, const std::string& name) {
  for (const Parameter& p : f.parameters)
    if (p.name == name) return p;
  ADD_FAILURE() << f.effect << " has no " << name;
  static const Parameter none{};
  return none;
}

inline std::vector<std::string> names(const Diagnosis& diagnosis) {
  std::vector<std::string> out;
  for (const Finding& f : diagnosis.findings) out.push_back(f.effect);
  return out;
}
inline std::vector<std::string> names(const Answer& answer) { return names(answer.diagnosis); }

}  // namespace stillpoint::diag::test

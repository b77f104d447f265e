/// A motion in which two laws, or a law and the matrix, are nearly one: what is stated of it holds in another motion.
#include <gtest/gtest.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

/// A boat rolls and heaves a little about one attitude: force, place and the vertical go along with each other.
sim::SimulationConfig on_a_boat(const std::string& effects) {
  return test::parsed(
      "rate_hz: 50\naccelerometer: {noise_mps2: 0.004}\ngyroscope: {noise_radps: 0.0002}\n"
      "magnetometer: {noise_uT: 0.03}\nmotion: {kind: boat, duration_s: 60}\n"
      "reference: {kind: mocap, orientation_sd_rad: 0.0006, position_sd_m: 0.0001, band_hz: 5}\n"
      "environment: {temperature: {kind: warm_up, rise_K: 15}}\neffects: " +
      effects);
}

double rms_between(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(OneMotion, WhatIsStatedOfItMakesNoOtherWorse) {
  const sim::SimulationConfig truth =
      on_a_boat("[{effect: law, sensor: acc, law: \"log(1 + t / 3.5)\", k: [0.03, 0, 0.02]}]");
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    sim::SimulationConfig given = truth;
    given.effects.clear();
    sim::SimulationConfig improved = given;
    improved.effects = diagnose(test::record(truth, "", {}, seed), given).effects;
    std::erase_if(improved.effects, [](const auto& e) { return e.id.ends_with("_quant") || e.id == "ref_error"; });
    const auto by_hand = [seed](sim::SimulationConfig c) {
      c.motion->kind = "hand";
      return test::record(c, "", {}, seed + 10);
    };
    const io::Recording real = by_hand(truth), before = by_hand(given), after = by_hand(improved);
    EXPECT_LE(rms_between(after.acc_mps2, real.acc_mps2), 1.05 * rms_between(before.acc_mps2, real.acc_mps2)) << seed;
    EXPECT_LE(rms_between(after.mag_uT, real.mag_uT), 1.05 * rms_between(before.mag_uT, real.mag_uT) + 0.01) << seed;
  }
}

}  // namespace
}  // namespace stillpoint::diag

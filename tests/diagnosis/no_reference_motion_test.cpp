/// Without a reference and without a rest: gyroscope and magnetometer by each other, and what a body that is never at
/// rest, or seems to be, must not be told for.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "diagnosis/no_reference/no_reference.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

sim::SimulationConfig simulated(const std::string& motion, const std::string& effects = "[]") {
  return test::without_reference(motion, effects, ", current: {kind: steps}");
}

/// From the middle of a long bout of motion.
const std::string kBout = "{kind: hand, duration_s: 65, min_bout_s: 65, max_bout_s: 65, min_rest_s: 4}";

const Vec3 kOffset(0.05, -0.03, 0.02);  // of the gyroscope, rad/s; the simulation has none

io::Recording never_at_rest(const std::string& effects, std::uint64_t seed) {
  auto truth = simulated(kBout, effects);
  truth.gyroscope->bias = kOffset;
  io::Recording r = io::to_recording(sim::simulate(truth, seed));
  const auto cut = [](auto& column) {
    if (!column.empty()) column.erase(column.begin(), column.begin() + 1000);
  };
  cut(r.t_ns), cut(r.acc_mps2), cut(r.gyr_radps), cut(r.mag_uT), cut(r.temp_degC), cut(r.current_A), cut(r.supply_V);
  cut(r.ref_moving);
  return r;
}

TEST(NeverAtRest, NothingIsMissingButTheOffset) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto d = diagnose_without_reference(never_at_rest("[]", seed), simulated(kBout));
    EXPECT_TRUE(d.findings.empty()) << d.summary;
    EXPECT_EQ(d.verdict, Verdict::kWrongNumbers) << d.summary;
    ASSERT_EQ(d.configuration.size(), 1U);
    double x = 0.0, y = 0.0, z = 0.0;
    ASSERT_EQ(std::sscanf(d.configuration[0].what.c_str(), "bias wrong by (%lf, %lf, %lf)", &x, &y, &z), 3);
    EXPECT_LT((Vec3(x, y, z) - kOffset).norm(), 1.5e-3) << d.configuration[0].what;
  }
}

TEST(NeverAtRest, TheFieldTellsLawsOfMagnetometerAndGyroscope) {
  struct {
    std::string effect, entry, number;
    double value, half;  ///< of the 95 % interval at most
  } const cases[]{
      {"mag_current", "{effect: mag_current, k_uT_per_A: [0.8, -0.5, 0.4]}", "k_x", 0.8, 0.03},
      {"mag_delay", "{effect: mag_delay, tau_s: 0.012}", "tau", 0.012, 0.0005},
      {"gyr_temp_lin", "{effect: gyr_temp_lin, k_radps_per_K: [5e-4, -3e-4, 4e-4]}", "k_x", 5e-4, 6e-5},
      {"mag_hard_step", "{effect: mag_hard_step, b_uT: [1.5, -1, 2], t0_s: 30}", "b_x", 1.5, 0.1},
  };
  for (const auto& c : cases) {
    const auto d = diagnose_without_reference(never_at_rest("[" + c.entry + "]", 4), simulated(kBout));
    const Finding* f = test::finding(d, c.effect);
    ASSERT_NE(f, nullptr) << c.effect << ": " << d.summary;
    EXPECT_EQ(d.findings.size(), 1U) << d.summary;
    const Parameter& p = test::parameter(*f, c.number);
    const double half = 0.5 * (p.ci95[1] - p.ci95[0]);
    EXPECT_NEAR(p.value, c.value, 1.5 * half) << c.effect;
    EXPECT_LT(half, c.half) << c.effect;
  }
}

/// A magnetometer's offset that flickers is a walk to within its noise, and no step, temperature or iron.
TEST(NeverAtRest, FlickerIsNoLaw) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    io::Recording r = never_at_rest("[]", seed);
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    Vec3 offset = Vec3::Zero();
    for (Vec3& m : r.mag_uT) {
      for (double& x : offset) x += 0.0015 * normal(engine);  // 0.11 uT in 55 s, beside noise of 0.2
      m += offset;
    }
    const auto d = diagnose_without_reference(r, simulated(kBout));
    EXPECT_TRUE(d.findings.empty()) << seed << ": " << d.summary;
  }
}

/// At anchor a body turns so slowly that it seems to rest, and sways.
TEST(SeemsToRest, ASwayTellsNoMatrix) {
  const std::string boat = "{kind: boat, duration_s: 90}";
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto d = diagnose_without_reference(io::to_recording(sim::simulate(simulated(boat), seed)), simulated(boat));
    EXPECT_TRUE(d.findings.empty()) << seed << ": " << d.summary;
    for (const ConfigurationFault& fault : d.configuration) ADD_FAILURE() << seed << ": " << fault.what;
  }
}

/// Cruising at one speed is a rest to gyroscope and accelerometer, and so is a steady acceleration, but for gravity.
TEST(SeemsToRest, ASteadyAccelerationTellsNoMatrixAndNoLaw) {
  const std::string hand = "{kind: hand, duration_s: 60, max_bout_s: 6, min_rest_s: 4}";
  for (const std::uint64_t seed : {1U, 2U}) {
    const auto truth = simulated(hand);
    io::Recording r = io::to_recording(sim::simulate(truth, seed));
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    Vec3 acceleration = Vec3::Zero();  // from rest to rest another one
    for (std::size_t i = 0; i < r.size(); ++i) {
      const bool moves = r.gyr_radps[i].norm() > 0.1;
      if (moves && i % 50 == 0) acceleration = 0.4 * Vec3(normal(engine), normal(engine), normal(engine));
      r.acc_mps2[i] += acceleration;
    }
    const auto d = diagnose_without_reference(r, truth);
    EXPECT_TRUE(d.findings.empty()) << seed << ": " << d.summary;
    EXPECT_TRUE(d.configuration.empty()) << seed << ": " << d.configuration[0].what;
  }
}

}  // namespace
}  // namespace stillpoint::diag

/// A reference that turns slowly against the sensors is no physics of theirs.
#include "diagnosis/reference/wandering_reference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

TEST(WanderingReference, ItsTurnsAreNoLaw) {
  auto config = test::baseline("mocap", 60.0);
  io::Recording r = test::record(config, "", {}, 11);
  test::turn_reference(r, [](double t) { return Vec3(4e-3 * std::sin(0.11 * t), 4e-3 * std::cos(0.17 * t), 0.0); });
  Result<Signals> s = make_signals(r, config, {});
  ASSERT_TRUE(s);
  SensorSearch search = start_search(*s, kMag);
  Found product;
  product.id = "unknown:m*t";
  product.names = {"k"};
  Series3 x(s->n, 3);
  for (Eigen::Index i = 0; i < s->n; ++i)
    x.row(i) = std::sin(0.11 * s->t_s[i]) * Vec3::UnitX().cross(Vec3(s->vector[kMag].row(i).transpose()));
  product.columns = {{-1, x}};
  const double alone = fit_profile(search.beside_walk(), product.columns).log_likelihood -
                       fit_profile(search.beside_walk(), {}).log_likelihood;
  EXPECT_GT(alone, 20.0) << "it fits";
  EXPECT_FALSE(stands_beside_wandering(*s, search, product));
  s->exact_reference = true;
  EXPECT_TRUE(stands_beside_wandering(*s, search, product)) << "an exact reference does not turn";
}

/// Markers that settle by two milliradians, beside sensors that are ten times as good.
TEST(WanderingReference, NoSensorIsBlamedForIt) {
  const auto recorded = [](const std::string& effects, std::uint64_t seed) {
    sim::SimulationConfig config = test::parsed(
        "rate_hz: 50\naccelerometer: {noise_mps2: 0.004}\ngyroscope: {noise_radps: 0.0002}\n"
        "magnetometer: {noise_uT: 0.05}\nmotion: {kind: hand, duration_s: 45}\n"
        "environment: {temperature: {kind: activity}}\n"
        "reference: {kind: mocap, orientation_sd_rad: 0.0005, position_sd_m: 0.0001, band_hz: 4.3}\neffects:\n" +
        effects);
    io::Recording r = test::record(config, "", {}, seed);
    test::turn_reference(r, [](double t) -> Vec3 { return std::sin(0.126 * t + 1.0) * Vec3(2e-3, -1.5e-3, 1e-3); });
    config.effects.clear();
    return diagnose(r, config);
  };
  const Answer clean = recorded("  []", 2);
  EXPECT_TRUE(clean.diagnosis.findings.empty()) << clean.diagnosis.summary;
  EXPECT_TRUE(clean.effects.empty());
  const Answer true_law = recorded("  - {effect: law, sensor: mag, law: \"f_y * f_z\", k: [0.01, -0.02, 0.01]}", 1);
  EXPECT_THAT(test::names(true_law), testing::ElementsAre("unknown:f_y*f_z")) << "what it cannot have done";
}

TEST(WanderingReference, MayBeWhatASmallLawOfTheAccelerometerIsTakenFor) {
  auto config = test::baseline("mocap", 60.0);
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  for (const auto& [k, small] : {std::pair{3e-4, true}, std::pair{1e-2, false}}) {
    const io::Recording r = test::record(config, "acc_temp_lin", {{"k_mps2_per_K", {k, -k, k}}}, 11);
    Result<Signals> s = make_signals(r, config, {});
    ASSERT_TRUE(s);
    Found law;
    law.id = "acc_temp_lin";
    for (int axis = 0; axis < 3; ++axis) law.columns.push_back({axis, s->temperature_K});
    const SensorSearch search = start_search(*s, kAcc);
    const Fit beside = fit_beside(search, law);
    EXPECT_EQ(as_small_as_wandering(*s, search, law, beside), small) << k;
    s->exact_reference = true;
    EXPECT_FALSE(as_small_as_wandering(*s, search, law, beside));
  }
}

}  // namespace
}  // namespace stillpoint::diag

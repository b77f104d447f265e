/// A reference that turns slowly against the sensors is no physics of theirs.
#include "diagnosis/reference/wandering_reference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/reference/columns.h"
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

/// A vehicle goes far: what its reference wanders by is then a gradient, where the configured field is wrong as well.
TEST(WanderingReference, IsNoGradientBesideAFieldThatIsWrong) {
  auto config = test::baseline("mocap", 60.0);
  config.motion->kind = "vehicle";
  config.magnetometer->noise_sd = 0.03;
  io::Recording r = test::record(config, "", {}, 11);
  test::turn_reference(r, [](double t) -> Vec3 { return std::sin(0.05 * t) * Vec3(1e-3, -1.5e-3, 2e-3); });
  config.field_world_uT += Vec3(-0.5, 1.4, 0.2);
  Result<Signals> s = make_signals(r, config, {});
  ASSERT_TRUE(s);
  const SensorSearch search = start_search(*s, kMag);
  Found gradient;
  gradient.id = "mag_gradient";
  gradient.names = {"G_xx", "G_xy", "G_xz", "G_yy", "G_yz", "b_x", "b_y", "b_z"};
  gradient.columns = gradient_columns(*s);
  EXPECT_GT(fit_profile(search.beside_walk(), gradient.columns).log_likelihood -
                fit_profile(search.beside_walk(), {}).log_likelihood,
            50.0)
      << "it fits";
  EXPECT_FALSE(stands_beside_wandering(*s, search, gradient));
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

/// Its errors are no white noise: a hundredth of them goes along with something.
TEST(WanderingReference, NoUnknownLawIsStatedOfATraceOfItsErrors) {
  const auto config = test::baseline("mocap", 60.0);
  Result<Signals> s = make_signals(test::record(config, "", {}, 11), config, {});
  ASSERT_TRUE(s);
  SensorSearch search = start_search(*s, kAcc);
  Found law;
  law.id = "unknown:|w|";
  law.names = {"k_x"};
  law.columns = {{0, s->rate.rowwise().norm()}};
  const double errors = search.target.residual.norm() / law.columns[0].x.norm();
  for (const auto& [share, trace] : {std::pair{0.005, true}, {0.1, false}}) {
    SensorSearch with = search;
    with.target.residual.col(0) += share * errors * law.columns[0].x.col(0);
    for (Eigen::Index i = 0; i < s->n; ++i)  // where the reference is lost, anything may be left over
      if (with.target.layout.present[i] == 0.0) with.target.residual.row(i).setConstant(1e3);
    EXPECT_EQ(is_a_trace_of_the_cameras(*s, with, law, fit_beside(with, law)), trace) << share;
    s->exact_reference = true;
    EXPECT_FALSE(is_a_trace_of_the_cameras(*s, with, law, fit_beside(with, law)));
    s->exact_reference = false;
  }
  law.id = "acc_quad";
  EXPECT_FALSE(is_a_trace_of_the_cameras(*s, search, law, fit_beside(search, law)))
      << "a law that sensors are known for";
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

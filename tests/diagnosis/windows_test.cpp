/// What acts in a part of the recording only keeps its name, and its window.
#include <gmock/gmock.h>

#include "diagnosis/reference/timing_in_window.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::names;
using test::Parameters;

constexpr double kFrom_s = 40.0, kUntil_s = 60.0;
constexpr double kRest_s = 3.0;  // an edge in a rest is not seen

io::Recording for_a_while(sim::SimulationConfig config, const std::string& id, const Parameters& parameters,
                          std::uint64_t seed) {
  config.effects.push_back({.id = id, .parameters = parameters, .axes = {}, .window_s = {{kFrom_s, kUntil_s}}});
  return test::record(config, "", {}, seed);
}

sim::SimulationConfig loaded() {
  auto config = test::baseline("exact");
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  config.environment.current.kind = "steps";
  return config;
}

TEST(Windows, ADelayOrAFilterThatIsSwitchedOnAndOffKeepsItsName) {
  const auto config = test::baseline("exact");
  for (const auto* id : {"gyr_delay", "acc_lpf", "mag_delay"}) {
    Answer answer = diagnose(for_a_while(config, id, {{"tau_s", {0.008}}}, 7), config);
    ASSERT_THAT(names(answer), testing::ElementsAre(id));
    const Finding& f = answer.diagnosis.findings.front();
    EXPECT_NEAR(f.interval_s[0], kFrom_s, kRest_s) << id;
    EXPECT_NEAR(f.interval_s[1], kUntil_s, kRest_s) << id;
    EXPECT_NEAR(f.parameters.front().value, 0.008, 0.001) << id;
  }
}

/// A clock that is off for a while delays every sensor by the same. So short a delay is a low-pass to each of them.
TEST(Windows, AClockThatIsOffForAWhileIsOneCause) {
  const auto config = test::baseline("exact");
  for (const double tau_s : {3e-4, 0.008}) {
    const io::Recording recording = for_a_while(config, "sys_offset", {{"tau_s", {tau_s}}}, 7);
    const Answer answer = diagnose(recording, config);
    ASSERT_THAT(names(answer), testing::ElementsAre("sys_offset")) << tau_s;
    const Finding& f = answer.diagnosis.findings.front();
    EXPECT_NEAR(f.interval_s[0], kFrom_s, kRest_s) << tau_s;
    EXPECT_NEAR(f.interval_s[1], kUntil_s, kRest_s) << tau_s;
    EXPECT_NEAR(f.parameters.front().value, tau_s, 0.1 * tau_s);
    auto improved = config;
    improved.effects = answer.effects;
    EXPECT_THAT(names(diagnose(recording, improved)), testing::IsEmpty()) << tau_s;
  }
}

/// A quarter of a second is some other motion; the frequency of a resonance is no time.
TEST(Windows, ADelayThatIsSwitchedOnIsNoLongerThanAFilter) {
  const Result<Signals> s =
      make_signals(test::record(test::baseline("exact", 60.0), "", {}, 7), test::baseline("exact"), {});
  ASSERT_TRUE(s);
  for (const TimingLaw& law : make_timing_laws(*s, kAcc, 0)) {
    const auto at = [&](const Window& w, double x) {
      Eigen::VectorXd numbers = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(law.names.size()), 0.1);
      numbers[0] = x;
      return in_window(law, w).possible(numbers);
    };
    const Window window{true, 100, 900};
    if (law.id == "acc_delay") {
      EXPECT_TRUE(at(window, -0.1));
      EXPECT_FALSE(at(window, 0.26));
      EXPECT_TRUE(at({}, 0.26)) << "a clock that was never set";
    } else if (law.id == "acc_resonance") {
      EXPECT_TRUE(at(window, 20.0));
    }
  }
}

/// What seven seconds leave over at fifty times the noise passes for the colour of all of it, beside which a derivative
/// fits as well as a delay.
TEST(Windows, AStrongOneForAFewSecondsOfAGoodSensorIsNoDerivative) {
  auto config = test::baseline("exact", 60.0);
  config.rate_hz = 100;
  config.gyroscope->noise_sd = 2e-4, config.accelerometer->noise_sd = 3e-3;
  for (const std::string sensor : {"gyr", "acc"})
    for (const std::uint64_t seed : {1, 2, 3}) {
      auto real = config;
      real.effects = {{.id = sensor + "_delay", .parameters = {{"tau_s", {0.008}}}, .axes = {}, .window_s = {{6, 13}}}};
      const Answer answer = diagnose(test::record(real, "", {}, seed), config);
      ASSERT_THAT(names(answer), testing::ElementsAre(sensor + "_delay")) << seed;
      EXPECT_NEAR(answer.diagnosis.findings.front().parameters.front().value, 0.008, 1e-3);
    }
}

/// A line that lasts a sixth of the recording stands over nothing in the spectrum of the whole, beside what a camera
/// leaves of the motion.
TEST(Windows, ALineForAFewSecondsBesideANoisyCameraIsFound) {
  auto config = test::baseline("mocap", 60.0);
  config.rate_hz = 100;
  config.accelerometer->noise_sd = 0.002;
  config.reference = {.kind = "mocap", .orientation_sd_rad = 4e-4, .position_sd_m = 1.4e-4, .band_hz = 4.0};
  for (const std::uint64_t seed : {1, 2, 3}) {
    auto real = config;
    real.effects = {{.id = "acc_alias",
                     .parameters = {{"b_mps2", {-0.1, 0.15, -0.3}}, {"f_hz", {185.7}}},
                     .axes = {},
                     .window_s = {{19, 28.5}}}};
    const Answer answer = diagnose(test::record(real, "", {}, seed), config);
    ASSERT_THAT(names(answer), testing::Contains("acc_alias")) << seed;
    const auto is_line = [](const Finding& f) { return f.effect == "acc_alias"; };
    const Finding& f = *std::ranges::find_if(answer.diagnosis.findings, is_line);
    EXPECT_NEAR(f.interval_s[0], 19.0, 1.5) << seed;
    EXPECT_NEAR(f.interval_s[1], 28.5, 1.5) << seed;
  }
}

TEST(Windows, RowsLostFromOneOnAreNoDelayUntilTheEnd) {
  const auto config = test::baseline("exact");
  const Answer answer = diagnose(test::record(config, "sys_gap", {{"n", {4}}, {"t0_s", {45}}}, 7), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("sys_gap"));
  EXPECT_THAT(answer.diagnosis.findings.front().equivalent, testing::IsEmpty());
}

/// A row beside its first one leaves thousands of nats over, and what gains a fiftieth of it was taken for the
/// remainder.
TEST(Windows, WhatGainsLittleBesideAGapIsFound) {
  auto config = loaded();
  config.motion->duration_s = 50.0;
  config.accelerometer->noise_sd = 0.01, config.gyroscope->noise_sd = 5e-4;
  for (const std::uint64_t seed : {5, 6, 7}) {
    auto real = config;
    real.effects = {
        {.id = "gyr_temp_lin", .parameters = {{"k_radps_per_K", {2e-4, -1e-4, 3e-4}}}, .axes = {}, .window_s = {}}};
    const Answer answer = diagnose(test::record(real, "sys_gap", {{"n", {3}}, {"t0_s", {22}}}, seed), config);
    EXPECT_THAT(names(answer), testing::ElementsAre("sys_gap", "gyr_temp_lin")) << seed;
  }
}

/// The body lies still at the end, so that nothing tells a shift that ends from one that does not.
TEST(Windows, RowsLostBeforeARestAreNoRateOfTheClock) {
  auto config = test::baseline("exact", 60.0);
  config.motion->kind = "rest_poses";
  const Answer answer = diagnose(test::record(config, "sys_gap", {{"n", {4}}, {"t0_s", {30}}}, 2), config);
  EXPECT_THAT(names(answer), testing::ElementsAre("sys_gap")) << answer.diagnosis.summary;
}

/// Half of nine seconds did not show all coefficients of a lever, and it was not stated.
TEST(Windows, WhatActsForAWhileIsJudgedOnAThirdOfIt) {
  auto config = test::baseline("exact", 60.0);
  config.rate_hz = 100;
  config.accelerometer->noise_sd = 0.0026, config.gyroscope->noise_sd = 4e-4;
  auto real = config;
  real.effects = {
      {.id = "acc_lever", .parameters = {{"r_m", {-0.005, -0.03, 0.0125}}}, .axes = {}, .window_s = {{25.85, 40}}}};
  io::Recording recording = test::record(real, "", {}, 3);
  for (std::size_t i = 3550; i < 4550; ++i)
    recording.ref_q_world_body[i].setConstant(io::kMissing), recording.ref_position_m[i].setConstant(io::kMissing);
  EXPECT_THAT(names(diagnose(recording, config)), testing::ElementsAre("acc_lever"));
}

/// A law of four seconds fits what lasts less than one, and predicts nothing of it. It is not stated; nor is it said
/// that the simulation explains the recording.
TEST(Windows, WhatNoLawPredictsIsNoMatch) {
  const auto truth = test::with_law(
      "  - {effect: law, sensor: acc, law: \"f * step(t, 26) * step(-t, -26.7)\", k: [0.03, -0.02, 0.01]}", "0.0004");
  auto config = truth;
  config.effects.clear();
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Answer answer = diagnose(test::record(truth, "", {}, seed), config);
    ASSERT_EQ(answer.diagnosis.verdict, Verdict::kUnexplained) << seed << ": " << answer.diagnosis.summary;
    const Finding& f = answer.diagnosis.findings.front();
    EXPECT_GE(f.interval_s[0], 25.5) << seed << ": and it is said when";
    EXPECT_LE(f.interval_s[1], 27.5) << seed;
  }
}

TEST(Windows, TheImprovedSimulationHasTheDelayInItsWindow) {
  auto config = test::baseline("exact");
  const io::Recording recording = for_a_while(config, "gyr_delay", {{"tau_s", {0.008}}}, 7);
  config.effects = diagnose(recording, config).effects;
  ASSERT_EQ(config.effects.size(), 1U);
  EXPECT_TRUE(config.effects.front().window_s);
  EXPECT_THAT(names(diagnose(recording, config)), testing::IsEmpty());
}

TEST(Windows, TheSupplyThatMattersForAWhileIsNamed) {
  const Parameters k{{"k_radps_per_V", {0.010, -0.006, 0.008}}};
  for (const std::uint64_t seed : {3, 4})
    EXPECT_THAT(names(diagnose(for_a_while(loaded(), "gyr_volt", k, seed), loaded())), testing::ElementsAre("gyr_volt"))
        << seed;
}

TEST(Windows, WhatFollowsTemperatureForAWhileKeepsItsLaw) {
  auto config = loaded();
  config.environment.temperature = {.kind = "chamber", .start_degC = 10.0, .rise_K = 30.0, .period_s = 25.0};
  const std::vector<std::pair<std::string, Parameters>> laws{
      {"acc_temp_scale", {{"S_per_K", {2e-3, -1.5e-3, 1e-3}}}},
      {"mag_temp_scale", {{"S_per_K", {5e-3, -4e-3, 6e-3}}}},
      {"gyr_temp_quad", {{"k2_radps_per_K2", {6e-5, -4e-5, 5e-5}}}}};
  for (const auto& [id, parameters] : laws)
    EXPECT_THAT(names(diagnose(for_a_while(config, id, parameters, 5), config)), testing::ElementsAre(id));
}

/// Held to six seconds it takes in a second and a half in which nothing acts, and no law of temperature fits that.
TEST(Windows, AShortOneHasItsOwnEdges) {
  auto config = loaded();
  config.environment.temperature = {.kind = "chamber", .start_degC = 10.0, .rise_K = 30.0, .period_s = 25.0};
  auto real = config;
  real.effects.push_back({.id = "acc_temp_scale",
                          .parameters = {{"S_per_K", {2e-3, -1.5e-3, 1e-3}}},
                          .axes = {},
                          .window_s = {{40.0, 44.5}}});
  const Answer answer = diagnose(test::record(real, "", {}, 5), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("acc_temp_scale"));
  EXPECT_NEAR(answer.diagnosis.findings.front().interval_s[0], 40.0, 0.5);
  EXPECT_NEAR(answer.diagnosis.findings.front().interval_s[1], 44.5, 0.5);
}

TEST(Windows, TheTemperatureOfAWindowInWhichItHardlyChangesIsNotNamed) {
  auto config = loaded();
  config.environment.temperature.tau_s = 8.0;
  const Parameters k{{"k_mps2_per_K", {0.01, -0.02, 0.015}}};
  EXPECT_THAT(names(diagnose(for_a_while(config, "acc_temp_lin", k, 5), config)),
              testing::Each(testing::Not(testing::HasSubstr("temp"))));
}

}  // namespace
}  // namespace stillpoint::diag

/// Diagnosis without a reference, on simulated hand motion with rests: what is put in must come out by name and size.
#include "diagnosis/no_reference/no_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <sstream>

#include "diagnosis/diagnose.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/forensics.h"
#include "diagnosis/prove/prove.h"
#include "simulation/effect_catalogue.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

sim::SimulationConfig baseline() { return test::baseline("none", 90.0); }

io::Recording record(const sim::SimulationConfig& config, std::uint64_t seed) {
  return test::record(config, "", {}, seed);
}

Diagnosis diagnosed(const std::string& id, const std::map<std::string, std::vector<double>>& parameters,
                    std::uint64_t seed) {
  auto truth = baseline();
  truth.effects.push_back({.id = id, .parameters = parameters, .axes = {}, .window_s = {}});
  return diagnose_without_reference(record(truth, seed), baseline());
}

TEST(NoReference, SaysNothingOfCleanRecordings) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto d = diagnose_without_reference(record(baseline(), seed), baseline());
    EXPECT_EQ(d.verdict, Verdict::kNoMismatch) << d.summary;
    EXPECT_TRUE(d.findings.empty());
    EXPECT_FALSE(d.notices.empty()) << "the accelerometer is not witnessed, and that must be said";
  }
}

/// A recording that was switched on in the hand: what lies before the first rest has no known attitude.
TEST(NoReference, SaysNothingOfRecordingsThatBeginInMotion) {
  const io::Recording whole = record(baseline(), 5);
  for (const std::size_t first : {300U, 700U, 1000U}) {
    io::Recording r = whole;
    const auto cut = [&](auto& column) {
      if (!column.empty()) column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(first));
    };
    cut(r.t_ns), cut(r.acc_mps2), cut(r.gyr_radps), cut(r.mag_uT), cut(r.temp_degC), cut(r.current_A), cut(r.supply_V);
    cut(r.ref_moving);
    const auto d = diagnose_without_reference(r, baseline());
    EXPECT_EQ(d.verdict, Verdict::kNoMismatch) << first << ": " << d.summary;
  }
}

TEST(NoReference, NamesGravitySensitivityWithItsMatrix) {
  const std::vector<double> G{2e-4, -1e-4, 0, 1e-4, 1.5e-4, 0, -2e-4, 0, 1e-4};
  const auto d = diagnosed("gyr_gsens", {{"G_radps_per_mps2", G}}, 3);
  ASSERT_FALSE(d.findings.empty()) << d.summary;
  ASSERT_EQ(d.findings[0].effect, "gyr_gsens");
  for (std::size_t i = 0; i < 9; ++i) {
    const auto& p = d.findings[0].parameters[i];
    EXPECT_NEAR(p.value, G[i], 1.0 * (p.ci95[1] - p.ci95[0])) << i;  // twice the half width: 1 in 10 000 for each
    EXPECT_LT(p.ci95[1] - p.ci95[0], 4e-5) << i;
  }
}

/// Numbers of a law with one number an axis, within twice their half width.
void expect_axes(const Finding& f, const std::vector<double>& truth, double largest_width) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& p = f.parameters[k];
    EXPECT_NEAR(p.value, truth[k], p.ci95[1] - p.ci95[0]) << k;
    EXPECT_LT(p.ci95[1] - p.ci95[0], largest_width) << k;
  }
}

TEST(NoReference, NamesTheAsymmetryOfTheGyroscopeFromTheClosureOfItsTurns) {
  const std::vector<double> k{6e-4, -3e-4, 5e-4};
  const auto d = diagnosed("gyr_asym", {{"k", k}}, 7);
  ASSERT_FALSE(d.findings.empty()) << d.summary;
  ASSERT_EQ(d.findings[0].effect, "gyr_asym");
  expect_axes(d.findings[0], k, 4e-4);
}

TEST(NoReference, NamesTheCurvatureOfTheGyroscope) {
  const std::vector<double> k{1.5e-3, -1e-3, 1.2e-3};
  const auto d = diagnosed("gyr_cubic", {{"k3_per_radps_2", k}}, 8);
  ASSERT_FALSE(d.findings.empty()) << d.summary;
  ASSERT_EQ(d.findings[0].effect, "gyr_cubic");
  expect_axes(d.findings[0], k, 4e-4);  // the widest axis over seeds 1 to 12: 1.1e-4 to 3.7e-4
}

/// So large that the attitude integrated with it, and everything judged by that attitude, is bent.
TEST(NoReference, NamesACurvatureThatBendsTheAttitude) {
  const SealedCase c = draw_case("final-600", 86, true);
  ASSERT_TRUE(c.truth.effects.contains("gyr_cubic"));
  const auto d = diagnose_without_reference(c.recording, c.baseline);
  ASSERT_FALSE(d.findings.empty()) << d.summary;
  EXPECT_EQ(d.findings[0].effect, "gyr_cubic");
}

TEST(NoReference, NamesTheDelayOfTheMagnetometer) {
  const auto d = diagnosed("mag_delay", {{"tau_s", {0.02}}}, 4);
  ASSERT_FALSE(d.findings.empty()) << d.summary;
  ASSERT_EQ(d.findings[0].effect, "mag_delay");
  EXPECT_NEAR(d.findings[0].parameters[0].value, 0.02, 0.001);
}

TEST(NoReference, TellsAnIronThatTurnsWithTheBodyFromAFieldThatStandsInTheWorld) {
  const auto body = diagnosed("mag_hard_step", {{"b_uT", {1.5, -1.0, 0.8}}, {"t0_s", {60}}}, 5);
  ASSERT_FALSE(body.findings.empty());
  EXPECT_EQ(body.findings[0].effect, "mag_hard_step");
  const auto world = diagnosed("mag_field_step", {{"b_world_uT", {1.5, -1.0, 1.2}}, {"t0_s", {60}}}, 5);
  ASSERT_FALSE(world.findings.empty());
  EXPECT_EQ(world.findings[0].effect, "mag_field_step");
}

/// 5 deg/s of offset and a matrix off by 2 % are numbers of the configuration, not physics.
TEST(NoReference, ReportsAWrongOffsetAndMatrixOfTheGyroscopeAsConfiguration) {
  auto truth = baseline();
  truth.gyroscope->bias += Vec3(0.08, -0.03, 0.02);
  truth.gyroscope->matrix(0, 0) += 0.02;
  const auto d = diagnose_without_reference(record(truth, 9), baseline());
  EXPECT_EQ(d.verdict, Verdict::kWrongNumbers) << d.summary;
  EXPECT_TRUE(d.findings.empty());
  ASSERT_EQ(d.configuration.size(), 2U);
  EXPECT_EQ(d.configuration[0].what.find("bias wrong by (0.08"), 0U) << d.configuration[0].what;
  const std::string& matrix = d.configuration[1].what;
  const std::string before = "D in % = [";
  ASSERT_NE(matrix.find(before), std::string::npos) << matrix;
  std::istringstream entries(matrix.substr(matrix.find(before) + before.size()));
  double xx = 0.0, xy = 0.0;
  char comma = 0;
  entries >> xx >> comma >> xy;
  // The sensor reads 1 / 1.02 of the truth. Within two standard deviations, as seeds 1 to 12 spread.
  EXPECT_NEAR(xx, 100.0 * (1.0 / 1.02 - 1.0), 0.05) << matrix;
  EXPECT_NEAR(xy, 0.0, 0.07) << matrix;
}

/// A matrix acts on the offset as well: about a wrong one its derivative is not that about the corrected reading.
TEST(NoReference, TellsWrongNumbersEverywhereWithIntervalsThatHold) {
  int told = 0;
  for (const std::uint64_t seed : {25U, 30U, 31U}) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    auto truth = baseline();
    struct Triad {
      std::string name;
      sim::TriadConfig* triad;
      double offset_sd;
    };
    const std::array<Triad, 3> sensors{
        {{"gyr", &*truth.gyroscope, 0.05}, {"acc", &*truth.accelerometer, 0.3}, {"mag", &*truth.magnetometer, 15.0}}};
    for (const auto& [name, sensor, offset_sd] : sensors) {
      for (double& b : sensor->bias) b += offset_sd * normal(random);
      for (double& h : sensor->matrix.reshaped()) h += 0.02 * normal(random);
    }
    const auto d = diagnose_without_reference(record(truth, seed), baseline());
    EXPECT_EQ(d.verdict, Verdict::kWrongNumbers) << seed << ": " << d.summary;
    EXPECT_TRUE(d.findings.empty()) << seed;
    EXPECT_FALSE(d.configuration.empty()) << seed;
    for (const ConfigurationFault& fault : d.configuration)
      for (const Parameter& p : fault.values) {
        if (!p.name.starts_with("bias_")) continue;  // a matrix is told up to a common turn of all sensors
        const Vec3& bias = std::find_if(sensors.begin(), sensors.end(), [&](const auto& x) {
                             return fault.sensor == x.name;
                           })->triad->bias;
        EXPECT_NEAR(p.value, bias[p.name.back() - 'x'], 1.5 * 0.5 * (p.ci95[1] - p.ci95[0]))
            << seed << " " << fault.sensor << " " << p.name;
        ++told;
      }
  }
  EXPECT_GE(told, 18);
}

TEST(NoReference, NumbersSetRightLeaveNothing) {
  auto truth = baseline();
  truth.gyroscope->bias += Vec3(0.08, -0.03, 0.02);
  truth.gyroscope->matrix(0, 0) += 0.02;
  truth.magnetometer->bias += Vec3(4, -6, 5);
  const io::Recording recording = record(truth, 9);
  const Answer answer = diagnose(recording, baseline());
  auto right = baseline();
  ASSERT_TRUE(answer.numbers[kGyr].has_value());
  ASSERT_TRUE(answer.numbers[kMag].has_value());
  right.gyroscope = *answer.numbers[kGyr];
  right.magnetometer = *answer.numbers[kMag];
  if (answer.numbers[kAcc]) right.accelerometer = *answer.numbers[kAcc];
  const auto d = diagnose_without_reference(recording, right);
  EXPECT_EQ(d.verdict, Verdict::kNoMismatch) << d.summary;
}

/// A name that no simulation knows could not be modelled: the magnetometer has no quadratic law and no lag.
TEST(NoReference, NamesOnlyWhatASimulationCanHold) {
  const auto d = diagnosed("mag_temp_lin", {{"k_uT_per_K", {0.2, -0.15, 0.2}}}, 1);
  ASSERT_FALSE(d.findings.empty()) << d.summary;
  EXPECT_EQ(d.findings[0].effect, "mag_temp_lin");
  for (const RankedHypothesis& h : d.ranking) EXPECT_NE(sim::find_effect(h.effect), nullptr) << h.effect;
}

/// What is named goes into the improved simulation, by the catalogue's own symbols.
TEST(NoReference, WhatItNamesIsAnEntryOfASimulation) {
  const std::vector<std::pair<std::string, test::Parameters>> effects{
      {"mag_temp_scale", {{"S_per_K", {0.004, 0.003, -0.004}}}},
      {"gyr_temp_scale", {{"S_per_K", {0.002, 0.0015, -0.002}}}},
      {"gyr_cubic", {{"k3_per_radps_2", {1e-3, -1e-3, 1e-3}}}}};
  for (const auto& [id, parameters] : effects) {
    const auto d = diagnosed(id, parameters, 1);
    ASSERT_FALSE(d.findings.empty()) << id << ": " << d.summary;
    ASSERT_EQ(d.findings[0].effect, id);
    const auto entry = effect_of(d.findings[0]);
    ASSERT_TRUE(entry) << id;
    const auto& [key, values] = *parameters.begin();
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(entry->parameters.at(key)[k], values[k], 0.3 * std::abs(values[k])) << id;
  }
}

/// 0.6 deg/s that turn with gravity bend the attitude; what is settled before they are taken out stays bent.
TEST(NoReference, AStrongEffectThatTheSimulationHasIsTakenOutWhole) {
  auto truth = baseline();
  truth.effects.push_back({.id = "gyr_gsens",
                           .parameters = {{"G_radps_per_mps2", {0, 1e-3, 0, 0, 0, 1e-3, 1e-3, 0, 0}}},
                           .axes = {},
                           .window_s = {}});
  const auto d = diagnose_without_reference(record(truth, 2), truth);
  EXPECT_EQ(d.verdict, Verdict::kNoMismatch) << d.summary;
}

TEST(NoReference, AsksForRestWhereThereIsNoneAndNoMagnetometer) {
  auto r = record(baseline(), 6);
  r.mag_uT.clear();
  for (std::size_t i = 0; i < r.size(); ++i)
    r.gyr_radps[i] += Vec3::Constant(0.3 * std::sin(0.3 * static_cast<double>(i)));
  const auto d = diagnose_without_reference(r, baseline());
  EXPECT_EQ(d.verdict, Verdict::kInsufficientData);
  EXPECT_NE(d.summary.find("rest"), std::string::npos);
}

}  // namespace
}  // namespace stillpoint::diag

/// Laws outside the catalogue: found on one motion, right on another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "diagnosis/diagnose.h"
#include "diagnosis/discovery/law_words.h"
#include "diagnosis/improved.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "simulation/law_effect.h"
#include "simulation/simulator.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::with_law;

io::Recording recording_of(const sim::SimulationConfig& config, std::uint64_t seed) {
  return io::to_recording(sim::simulate(config, seed));
}

enum class Of { kAcc, kGyr, kMag };

/// rms of one sensor between two simulations of one motion.
double apart(const sim::SimulationConfig& a, const sim::SimulationConfig& b, std::uint64_t seed, Of sensor = Of::kGyr) {
  const auto x = recording_of(a, seed), y = recording_of(b, seed);
  const auto readings = [sensor](const io::Recording& r) {
    return sensor == Of::kAcc ? r.acc_mps2 : sensor == Of::kGyr ? r.gyr_radps : r.mag_uT;
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += (readings(x)[i] - readings(y)[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(x.size()));
}

/// The laws of an answer to a recording of `truth`, on another motion: how much of the error they leave.
double left_by(const Answer& answer, const sim::SimulationConfig& truth, Of sensor = Of::kGyr) {
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  sim::SimulationConfig improved = plain;
  for (const auto& e : answer.effects)
    if (sim::is_law(e)) improved.effects.push_back(e);
  return apart(improved, truth, 17, sensor) / apart(plain, truth, 17, sensor);
}

Answer answer_of(const sim::SimulationConfig& truth) {
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  return diagnose(recording_of(truth, 3), plain);
}

double left_on_another_motion(const sim::SimulationConfig& truth, Of sensor = Of::kGyr) {
  return left_by(answer_of(truth), truth, sensor);
}

TEST(Discovery, AProductOutsideTheCatalogueIsWrittenAsALawThatHoldsOnAnotherMotion) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"w_y * w_z\", k: [0.01, 0, -0.02]}");
  const Answer answer = answer_of(truth);
  ASSERT_THAT(answer.effects, testing::Contains(testing::Truly(sim::is_law))) << answer.diagnosis.summary;
  EXPECT_LT(left_by(answer, truth), 0.1) << io::format_effect(answer.effects.front());
}

/// The report's panels and its table of what was weighed stand on these.
TEST(Discovery, ALawComesWithWhatItWasWeighedAgainstAndTheResidualAgainstItsQuantities) {
  sim::SimulationConfig plain = with_law("  - {effect: law, sensor: gyr, law: \"w_y * w_z\", k: [0.01, 0, -0.02]}");
  const io::Recording recording = recording_of(plain, 3);
  plain.effects.clear();
  const Diagnosis d = diagnose(recording, plain).diagnosis;
  const auto law = std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return law_json(f); });
  ASSERT_NE(law, d.findings.end()) << d.summary;
  ASSERT_GT(law->weighed.size(), 1U);
  const auto stated = std::find_if(law->weighed.begin(), law->weighed.end(),
                                   [&](const WeighedLaw& w) { return w.text == law_text(law->effect); });
  ASSERT_NE(stated, law->weighed.end());
  std::set<std::string> texts;
  for (const WeighedLaw& w : law->weighed) {
    EXPECT_TRUE(texts.insert(w.text).second) << w.text << " twice";
    EXPECT_GT(w.bits, 0.0) << w.text;
    EXPECT_LE(w.net_nats, stated->net_nats) << w.text << ": the best after its price is the one that is stated";
  }
  EXPECT_EQ(law->figures.driver_label, "w_y*w_z, rad/s rad/s");
  const auto& panels = law->figures.against_each;
  const auto power = [](const std::vector<double>& v) {
    return std::inner_product(v.begin(), v.end(), v.begin(), 0.0);
  };
  std::vector<std::string> labels;
  for (const AgainstQuantity& a : panels) {
    labels.push_back(a.label);
    ASSERT_EQ(a.x.size(), a.before.size());
    EXPECT_LT(power(a.after), 0.3 * power(a.before)) << a.label;
  }
  EXPECT_THAT(labels, testing::IsSupersetOf({"w_y, rad/s", "w_z, rad/s", "T, degC"}));
}

TEST(Discovery, TheSizeOfTheAngularAccelerationIsADriver) {
  EXPECT_LT(left_on_another_motion(
                with_law("  - {effect: law, sensor: acc, law: \"norm(d(w))\", k: [-0.01, 0.008, -0.009]}"), Of::kAcc),
            0.1);
}

/// Ripple of a motor's current: a line of which the size is the current's.
TEST(Discovery, ALineThatFollowsTheCurrentIsALawOfIt) {
  EXPECT_LT(
      left_on_another_motion(
          with_law("  - {effect: law, sensor: mag, law: \"I * sin(t / 0.0115)\", k: [1.0, -0.4, 0.3]}"), Of::kMag),
      0.2);
}

/// A rotor under the accelerometer: where its current is switched its line is of no one size, and no line of its own.
TEST(Discovery, ALineThatASwitchedCurrentDrivesIsALawOfIt) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: acc, law: \"I * sin(t / 0.0115)\", k: [0.036, 0.038, -0.04]}");
  const Answer answer = answer_of(truth);
  EXPECT_LT(left_by(answer, truth, Of::kAcc), 0.2);
  for (const Finding& f : answer.diagnosis.findings)
    for (const Parameter& p : f.parameters)
      EXPECT_GT(p.ci95[1], p.ci95[0]) << f.effect << ": " << p.name << " is stated as if it were known to all digits";
}

/// In the body its line is smeared by the motion.
TEST(Discovery, AMagnetThatSpinsInTheWorldIsALawOfTheWorldsAxes) {
  EXPECT_LT(left_on_another_motion(with_law("  - {effect: law, sensor: mag, law: \"east * sin(t / 0.0206)\", k: 2.0}\n"
                                            "  - {effect: law, sensor: mag, law: \"north * cos(t / 0.0206)\", k: 2.0}"),
                                   Of::kMag),
            0.3);
}

/// Currents that a turning field drives in a conductor nearby.
TEST(Discovery, TheRateOfTheReadingThroughAMatrixIsALaw) {
  EXPECT_LT(
      left_on_another_motion(with_law("  - {effect: law, sensor: mag, law: \"d(m)\", matrix: [[-0.01, 0.02, 0.03], "
                                      "[0.01, -0.02, 0], [0.02, 0.01, 0.01]]}"),
                             Of::kMag),
      0.2);
}

TEST(Discovery, APeriodIsRefined) {
  EXPECT_LT(left_on_another_motion(
                with_law("  - {effect: law, sensor: gyr, law: \"sin(w / 0.21)\", k: [0.004, 0.003, -0.004]}")),
            0.2);
}

TEST(Discovery, ATimeConstantOfALagIsRefined) {
  EXPECT_LT(
      left_on_another_motion(with_law("  - {effect: law, sensor: gyr, law: \"lag(I, 3)\", k: [0.004, 0.003, -0.004]}")),
      0.2);
}

TEST(Discovery, HysteresisInATemperatureIsFound) {
  sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"play(T, 3)\", k: [0.002, -0.001, 0.002]}");
  truth.environment.temperature = {.kind = "activity", .rise_K = 12.0, .tau_s = 6.0};
  EXPECT_LT(left_on_another_motion(truth), 0.1);
}

/// A memory of its own reading as large as a fifth of it: the memory alone would take that fifth out of the matrix.
TEST(Discovery, WhatAMemoryOfTheReadingLacksIsFound) {
  EXPECT_LT(left_on_another_motion(
                with_law("  - {effect: law, sensor: gyr, law: \"w - lag(w, 0.6)\", k: [-0.2, -0.15, -0.18]}")),
            0.1);
}

TEST(Discovery, WhatEachAxisDoesByItsOwnSizeIsNoSizeOfAll) {
  EXPECT_LT(left_on_another_motion(with_law(
                "  - {effect: law, sensor: gyr, law: \"w * abs(w) * (T - 25)\", k: [0.0004, -0.0003, 0.0004]}")),
            0.1);
}

TEST(Discovery, AThirdFactorIsFound) {
  EXPECT_LT(left_on_another_motion(
                with_law("  - {effect: law, sensor: gyr, law: \"norm(w) * I * f_z\", k: [0.002, 0.001, -0.002]}")),
            0.2);
}

/// Three factors, one of them a vector through a matrix.
TEST(Discovery, AProductOfThreeWithAMatrixIsFound) {
  EXPECT_LT(
      left_on_another_motion(with_law(
          "  - {effect: law, sensor: gyr, law: \"w * (T - 25) * I\", matrix: [[1e-3, -4e-4, 5e-4], [0, 2e-4, 8e-4], "
          "[-6e-4, 3e-4, -9e-4]]}")),
      0.2);
}

/// Each of its three factors swings about zero, so that none of them shows alone, nor any two.
TEST(Discovery, AProductOfAxesThroughAMatrixIsFound) {
  EXPECT_LT(
      left_on_another_motion(
          with_law(
              "  - {effect: law, sensor: acc, law: \"w * f_y * m_x\", matrix: [[4e-5, -3e-5, 2e-5], [0, 5e-5, 3e-5], "
              "[-2e-5, 3e-5, -4e-5]]}"),
          Of::kAcc),
      0.2);
}

TEST(Discovery, AProductWithAnAxisThatIsRememberedIsFound) {
  EXPECT_LT(
      left_on_another_motion(
          with_law("  - {effect: law, sensor: mag, law: \"lag(w_z, 2.5) * f_x\", k: [0.05, -0.04, 0.03]}"), Of::kMag),
      0.25);
}

TEST(Discovery, AFormulaStandsWhereAFreeFunctionExplainsHardlyMore) {
  EXPECT_LT(
      left_on_another_motion(with_law("  - {effect: law, sensor: mag, law: \"step(I, 0.2) * (I - 0.2)\", k: [0.6, "
                                      "-0.5, 0.4]}"),
                             Of::kMag),
      0.2);
}

/// What an autoregression can follow hides as noise: the column gains 30 nats under it, and 500 with the noise anew.
TEST(Discovery, AColumnThatPassesForMemoryIsFound) {
  sim::SimulationConfig config = with_law("  []");
  io::Recording recording = recording_of(config, 3);
  auto& column = recording.user_columns["pump_rpm"];
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const double t = recording.t_s(i) - recording.t_s(0);
    column.push_back(1500.0 + 400.0 * (std::sin(0.9 * t) + std::sin(1.31 * t + 1.0) + std::sin(0.47 * t + 2.0)));
    recording.gyr_radps[i] += (column.back() - 1500.0) * Vec3(1.2e-6, -1e-6, 0.8e-6);
  }
  EXPECT_THAT(test::names(diagnose(recording, config)), testing::ElementsAre("unknown:pump_rpm"));
}

TEST(Discovery, AWindowInADriverIsFound) {
  EXPECT_LT(left_on_another_motion(
                with_law("  - {effect: law, sensor: gyr, law: \"f_y * step(w_z, 0.4)\", k: [4e-4, 3e-4, -5e-4]}")),
            0.2);
}

/// A curve that no formula of the search has.
constexpr const char* kTable =
    "  - {effect: table, sensor: gyr, driver: \"f_z\", x: [-12, -8, -4, 0, 4, 8, 12], y: [[0.002, -0.004, 0, 0.006, "
    "0.004, "
    "-0.003, 0.003], [0, 0.003, 0, -0.005, -0.003, 0.002, 0], [0, 0, 0, 0, 0, 0, 0]], clamp: true}";

TEST(Discovery, WhereNoFormulaIsGoodEnoughATableIsWrittenThatPredicts) {
  const sim::SimulationConfig truth = with_law(kTable);
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  const Answer answer = diagnose(recording_of(truth, 3), plain);
  // The table's constant stands in the bias.
  const sim::SimulationConfig improved = improved_by(answer, plain);
  ASSERT_FALSE(improved.effects.empty()) << answer.diagnosis.summary;
  EXPECT_TRUE(sim::is_table(improved.effects.front()));
  EXPECT_EQ(sim::expression_of(improved.effects.front()), "f_z");
  EXPECT_LT(apart(improved, truth, 17), 0.4 * apart(plain, truth, 17)) << io::format_effect(improved.effects.front());
  const auto law = law_json(answer.diagnosis.findings.front());
  ASSERT_TRUE(law);
  EXPECT_EQ((*law)["text"], "table(f_z)");
  EXPECT_EQ((*law)["drivers"], nlohmann::ordered_json::array({"f"}));
  const auto read = io::parse_simulation("gyroscope: {}\neffects:\n  - " + io::format_effect(improved.effects.front()),
                                         "improved.yaml");
  EXPECT_TRUE(read) << read.error().message;
}

}  // namespace
}  // namespace stillpoint::diag

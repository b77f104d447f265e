/// Laws outside the catalogue: found on one motion, right on another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "diagnosis/diagnose.h"
#include "diagnosis/discovery/law_words.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "simulation/law_effect.h"
#include "simulation/simulator.h"

namespace stillpoint::diag {
namespace {

sim::SimulationConfig with_law(const std::string& effects) {
  const auto config = io::parse_simulation(
      "rate_hz: 50\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: 0.0005}\n"
      "magnetometer: {noise_uT: 0.2}\nmotion: {kind: hand, duration_s: 60}\n"
      "environment: {temperature: {kind: warm_up, rise_K: 15}, current: {kind: steps}}\neffects:\n" +
          effects,
      "sim.yaml");
  EXPECT_TRUE(config) << (config ? "" : config.error().message);
  return config.value_or(sim::SimulationConfig{});
}

io::Recording recording_of(const sim::SimulationConfig& config, std::uint64_t seed) {
  return io::to_recording(sim::simulate(config, seed));
}

/// rms of the gyroscope between two simulations of one motion.
double apart(const sim::SimulationConfig& a, const sim::SimulationConfig& b, std::uint64_t seed) {
  const auto x = recording_of(a, seed), y = recording_of(b, seed);
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += (x.gyr_radps[i] - y.gyr_radps[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(x.size()));
}

TEST(Discovery, AProductOutsideTheCatalogueIsWrittenAsALawThatHoldsOnAnotherMotion) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"w_y * w_z\", k: [0.01, 0, -0.02]}");
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  const Answer answer = diagnose(recording_of(truth, 3), plain);
  sim::SimulationConfig improved = plain;
  for (const auto& e : answer.effects)
    if (sim::is_law(e)) improved.effects.push_back(e);
  ASSERT_FALSE(improved.effects.empty()) << answer.diagnosis.summary;
  EXPECT_LT(apart(improved, truth, 17), 0.1 * apart(plain, truth, 17)) << io::format_effect(improved.effects.front());
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
  for (const WeighedLaw& w : law->weighed) {
    EXPECT_GT(w.bits, 0.0) << w.text;
    EXPECT_LE(w.net_nats, stated->net_nats) << w.text << ": the best after its price is the one that is stated";
  }
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
  EXPECT_THAT(labels, testing::IsSupersetOf({"w_y, rad/s", "w_z, rad/s", "T"}));
}

TEST(Discovery, ACleanRecordingGivesNoLaw) {
  const sim::SimulationConfig clean = with_law("  []");
  for (const auto& e : diagnose(recording_of(clean, 4), clean).effects) EXPECT_FALSE(sim::is_law(e)) << e.id;
}

/// The rows of the laws that are found in a recording of `truth`, on another motion: how much of the error is left.
double left_on_another_motion(const sim::SimulationConfig& truth) {
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  const Answer answer = diagnose(recording_of(truth, 3), plain);
  sim::SimulationConfig improved = plain;
  for (const auto& e : answer.effects)
    if (sim::is_law(e)) improved.effects.push_back(e);
  return apart(improved, truth, 17) / apart(plain, truth, 17);
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

TEST(Discovery, AThirdFactorIsFound) {
  EXPECT_LT(left_on_another_motion(
                with_law("  - {effect: law, sensor: gyr, law: \"norm(w) * I * f_z\", k: [0.002, 0.001, -0.002]}")),
            0.2);
}

TEST(Discovery, ALawThatLeavesOnlyNoiseExplains) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"norm(w) * I\", k: [0.002, 0.001, -0.002]}");
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  const io::Recording recording = recording_of(truth, 3);
  const Answer answer = diagnose(recording, plain);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kExplained) << answer.diagnosis.summary;
  sim::SimulationConfig improved = plain;
  improved.effects = answer.effects;
  const Diagnosis again = diagnose(recording, improved).diagnosis;
  EXPECT_EQ(again.verdict, Verdict::kNoMismatch) << again.summary;
}

TEST(Discovery, ALawThatTheSimulationHasIsNotFoundAgain) {
  const sim::SimulationConfig truth =
      with_law("  - {effect: law, sensor: gyr, law: \"lag(w_y * w_z, 0.5)\", k: [0.01, 0, -0.02]}");
  const Answer answer = diagnose(recording_of(truth, 3), truth);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kNoMismatch) << answer.diagnosis.summary;
}

TEST(Discovery, ALawInTheAnswerHasUnitDriversAndMechanisms) {
  Finding finding;
  finding.effect = "unknown:w*(V-V0)";
  finding.channels = {"gyr_x"};
  const auto law = law_json(finding);
  ASSERT_TRUE(law);
  EXPECT_EQ((*law)["text"], "w * (V - 3.7)");
  EXPECT_EQ((*law)["unit"], "rad V/s");
  EXPECT_EQ((*law)["drivers"], nlohmann::ordered_json::array({"w", "V"}));
  EXPECT_THAT((*law)["mechanisms"].dump(), testing::HasSubstr("ratiometric"));
  finding.effect = "unknown:switched(t)";
  EXPECT_FALSE(law_json(finding));
}

}  // namespace
}  // namespace stillpoint::diag

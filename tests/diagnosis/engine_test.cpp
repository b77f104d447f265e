// The engine on recordings of our own simulator, where the truth is known: each effect comes back under its own name
// and size.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>

#include "diagnosis/prove/prove.h"
#include "diagnosis/reference/engine.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/findings.h"
#include "diagnosis/reference/refine.h"
#include "diagnosis/reference/response.h"
#include "diagnosis/summary.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::baseline;
using test::names;
using test::record;

class BothReferences : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Engine, BothReferences, testing::Values("exact", "mocap"));

TEST_P(BothReferences, SaysNothingOfACleanRecording) {
  const auto config = baseline(GetParam());
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    EXPECT_THAT(names(diagnose(record(config, "", {}, seed), config)), testing::IsEmpty()) << "seed " << seed;
}

TEST_P(BothReferences, ReportsAWrongBiasAsConfigurationAndNotAsPhysics) {
  const auto truth = baseline(GetParam());
  auto wrong = truth;
  wrong.gyroscope->bias += Vec3(0.02, 0, 0);
  const Answer answer = diagnose(record(truth, "", {}, 4), wrong);
  EXPECT_THAT(names(answer), testing::IsEmpty());
  ASSERT_FALSE(answer.diagnosis.configuration.empty());
  EXPECT_EQ(answer.diagnosis.configuration.front().sensor, "gyr");
}

TEST_P(BothReferences, NamesTheLeverArmWithItsLength) {
  const auto config = baseline(GetParam());
  const std::vector<double> r{0.03, -0.02, 0.04};
  const Answer answer = diagnose(record(config, "acc_lever", {{"r_m", r}}, 5), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("acc_lever"));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(answer.diagnosis.findings[0].parameters[i].value, r[i],
                2e-3);  // the driver itself is known to some percent
}

TEST_P(BothReferences, NamesTheCurrentAndHoldsItsSizeInTheInterval) {
  auto config = baseline(GetParam());
  config.environment.current.kind = "steps";
  const Answer answer = diagnose(record(config, "mag_current", {{"k_uT_per_A", {0.8, -0.5, 0.3}}}, 6), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("mag_current"));
  const Parameter& k = answer.diagnosis.findings[0].parameters[0];
  EXPECT_NEAR(k.value, 0.8, 3.0 * (k.ci95[1] - k.ci95[0]));
  EXPECT_LT(k.ci95[1] - k.ci95[0], 0.1);
}

/// Where the current falls to zero nobody sees whether its window goes on; the edge that is seen has to be found, and
/// the other one not to come closer than windows are believed.
/// The oscillator of a sensor on a chip warms up with it. Two numbers, in all sensors; where the temperature tells
/// nothing, one.
TEST_P(BothReferences, TellsAClockThatFollowsTheTemperature) {
  auto config = baseline(GetParam(), 80.0);
  config.environment.temperature = {.kind = "warm_up", .rise_K = 15.0, .tau_s = 25.0};
  const auto skew_of = [&](double k_ppm_per_K) {
    const Answer answer =
        diagnose(record(config, "sys_skew", {{"eps_ppm", {-300.0}}, {"k_ppm_per_K", {k_ppm_per_K}}}, 3), config);
    EXPECT_THAT(names(answer), testing::ElementsAre("sys_skew")) << answer.diagnosis.summary;
    return answer;
  };
  const Answer follows = skew_of(60.0);
  const auto& numbers = follows.diagnosis.findings.at(0).parameters;
  ASSERT_EQ(numbers.size(), 2U);
  EXPECT_LE(numbers[1].ci95[0], 60e-6);
  EXPECT_GE(numbers[1].ci95[1], 60e-6);
  EXPECT_NEAR(follows.effects.at(0).parameters.at("k_ppm_per_K").at(0), 60.0, 6.0);
  auto improved = config;
  improved.effects = follows.effects;
  const auto again =
      diagnose(record(config, "sys_skew", {{"eps_ppm", {-300.0}}, {"k_ppm_per_K", {60.0}}}, 5), improved);
  EXPECT_THAT(names(again), testing::IsEmpty()) << again.diagnosis.summary;
  EXPECT_EQ(skew_of(0.0).diagnosis.findings.at(0).parameters.size(), 1U);
}

TEST(Engine, AWindowThatIsSeenForTooShortIsHeldToTheShortestFromTheEdgeThatIsSeen) {
  auto config = baseline("exact", 60.0);
  config.environment.current.kind = "steps";
  auto recording = record(config, "", {}, 7);
  constexpr std::size_t kBegin = 1012, kOff = 1100;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.02);
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const double current_A = i < kBegin || i > 2000 ? 1.0 : i < kOff ? 1.6 : 0.0;
    recording.current_A[i] = current_A + noise(random);
    if (i >= kBegin && i < kOff) recording.mag_uT[i] += current_A * Vec3(1.2, -0.9, 0.6);
  }
  const auto signals = make_signals(recording, config, {});
  ASSERT_TRUE(signals);
  const Target target = make_target(*signals, kMag);
  const auto laws = make_laws(*signals, kMag);
  const auto law = std::find_if(laws.begin(), laws.end(), [](const Law& l) { return l.id == "mag_current"; });
  ASSERT_NE(law, laws.end());
  Candidate rough;
  rough.window = {true, 1000, 1150};
  const NoiseModel noise_beside(target.layout,
                                fit_profile(target, in_window(law->columns(0.0), rough.window)).leftover);
  const Window refined = refine_window(target, {}, *law, rough, noise_beside);
  EXPECT_NEAR(static_cast<double>(refined.begin), static_cast<double>(kBegin), 2.0);
  EXPECT_EQ(refined.end - refined.begin, static_cast<Eigen::Index>(kShortestWindow_s / signals->dt_s));
}

TEST(Engine, FindsNothingMoreOnceTheFindingIsInTheSimulation) {
  auto config = baseline("exact");
  const auto recording =
      record(config, "gyr_gsens", {{"G_radps_per_mps2", {1e-4, 0, 2e-4, 0, 1e-4, 0, 0, 1e-4, 1e-4}}}, 7);
  const Answer answer = diagnose(recording, config);
  ASSERT_THAT(names(answer), testing::ElementsAre("gyr_gsens"));
  ASSERT_EQ(answer.effects.size(), 1u);
  config.effects = answer.effects;
  EXPECT_EQ(diagnose(recording, config).diagnosis.verdict, Verdict::kNoMismatch);
}

/// Beside other laws its numbers may go where no filter is.
TEST(Engine, StatesNoFilterWhoseNumbersNoSensorHas) {
  const auto config = baseline("exact", 60.0);
  const auto recording = record(config, "acc_resonance", {{"f_hz", {20.0}}, {"zeta", {0.05}}}, 9);
  auto signals = make_signals(recording, config, {});
  ASSERT_TRUE(signals);
  EngineResult engine = search_all(*signals, {}, {});
  ASSERT_EQ(engine.sensor[kAcc]->found.size(), 1U);
  Found& found = engine.sensor[kAcc]->found.front();
  ASSERT_EQ(found.id, "acc_resonance");
  EXPECT_TRUE(found.possible(Eigen::Vector2d(20.0, 0.05)));
  EXPECT_FALSE(found.possible(Eigen::Vector2d(20.0, -0.01)));
  const auto said = [&] {
    Answer answer;
    report_sensor(*signals, engine, kAcc, {}, answer);
    return answer;
  };
  EXPECT_THAT(names(said()), testing::ElementsAre("acc_resonance"));
  found.timing[1] -= 0.2;  // what is fitted beside it is added to these
  const Answer answer = said();
  EXPECT_THAT(names(answer), testing::Not(testing::Contains("acc_resonance")));
  EXPECT_THAT(answer.diagnosis.notices, testing::Contains(testing::HasSubstr("none that a sensor has")));
}

TEST(Engine, LocatesAStepOfTheHardIronToTheTenthOfASecond) {
  const auto config = baseline("exact");
  const Answer answer =
      diagnose(record(config, "mag_hard_step", {{"b_uT", {2, -1, 1.5}}, {"t0_s", {47.3}}}, 8), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("mag_hard_step"));
  EXPECT_NEAR(answer.diagnosis.findings[0].interval_s[0], 47.3, 0.1);
}

/// A warm-up resembles many a drift. A walk may not be half taken for memory of the noise, or the temperature is
/// blamed.
TEST(Engine, DoesNotBlameAStrongWalkOnTheTemperature) {
  const auto config = baseline("exact");
  auto walking = config;
  for (const auto& [id, key, q] : {std::tuple{"acc_drift", "q_mps2_per_sqrts", 0.005},
                                   {"gyr_drift", "q_radps_per_sqrts", 1.6e-4},
                                   {"mag_drift", "q_uT_per_sqrts", 0.1}})
    walking.effects.push_back({.id = id, .parameters = {{key, {q, q, q}}}, .axes = {}, .window_s = {}});
  for (const std::uint64_t seed : {6, 16})
    EXPECT_THAT(names(diagnose(record(walking, "", {}, seed), config)),
                testing::UnorderedElementsAre("acc_drift", "gyr_drift", "mag_drift"))
        << "seed " << seed;
}

/// Half the rate of sampling falls between the bins of a spectrum of an odd number of rows.
TEST(Engine, TellsAFlipFromALineWhateverTheNumberOfRows) {
  std::set<std::size_t> parities;
  for (const double duration_s : {60.0, 60.02}) {
    const auto config = baseline("exact", duration_s);
    const io::Recording recording = record(config, "mag_flip", {{"b_uT", {1, 0.8, -0.6}}}, 9);
    EXPECT_THAT(names(diagnose(recording, config)), testing::ElementsAre("mag_flip")) << recording.size() << " rows";
    parities.insert(recording.size() % 2);
  }
  EXPECT_EQ(parities.size(), 2u);
}

/// A third of a cycle in the whole recording below half the rate: it beats with its own fold as if it were switched.
TEST(Engine, TellsALineBesideHalfTheRateFromAFlip) {
  const auto config = baseline("exact", 60.0);
  const double f_Hz = 25.0 - 0.33 / 60.0;
  const test::Parameters line{{"b_uT", {0.7, -0.2, -0.9}}, {"f_hz", {f_Hz}}, {"phase_rad", {0.56}}};
  const Answer answer = diagnose(record(config, "mag_line", line, 9), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("mag_line"));
  EXPECT_NEAR(test::parameter(answer.diagnosis.findings[0], "f").value, f_Hz, 5e-4);
}

/// Bias and matrix are free, so what begins late might as well have been there before with the other sign. Two sealed
/// cases in which chance prefers that, by a fraction of a nat.
TEST(Engine, AStepChangesWhatComesAfterItAndNotWhatCameBefore) {
  for (const std::size_t index : {29, 40}) {
    const SealedCase c = draw_case_of("pair", "cv1", index, true);
    const auto& truth = c.truth.effects.at("mag_soft_step");
    const Answer answer = diagnose(c.recording, c.baseline);
    const auto& findings = answer.diagnosis.findings;
    const auto step =
        std::find_if(findings.begin(), findings.end(), [](const Finding& f) { return f.effect == "mag_soft_step"; });
    ASSERT_NE(step, findings.end()) << index;
    EXPECT_NEAR(step->interval_s[0], truth.at("t0")[0], 0.5) << index;
    double along = 0.0;
    for (std::size_t i = 0; i < 9; ++i) along += step->parameters[i].value * truth.at("M")[i];
    EXPECT_GT(along, 0.0) << index;
  }
}

TEST(Engine, GivesACommonDelayToTheSystemAndALonelyOneToItsSensor) {
  const auto config = baseline("exact");
  EXPECT_THAT(names(diagnose(record(config, "sys_offset", {{"tau_s", {0.01}}}, 9), config)),
              testing::ElementsAre("sys_offset"));
  EXPECT_THAT(names(diagnose(record(config, "gyr_delay", {{"tau_s", {0.005}}}, 9), config)),
              testing::ElementsAre("gyr_delay"));
}

/// A camera that is late by less than what the accelerometer and the magnetometer can see: no sensor is early.
TEST(Engine, ASensorThatIsEarlyAloneStandsBesideAReferenceThatIsLate) {
  auto config = test::beside_a_good_camera();
  config.reference.position_sd_m = 1e-3;
  const auto late = diagnose(record(config, "sys_offset", {{"tau_s", {-1.5e-4}}}, 9), config);
  EXPECT_THAT(names(late), testing::ElementsAre("sys_offset"));
  EXPECT_THAT(names(diagnose(record(baseline("exact"), "gyr_delay", {{"tau_s", {-0.005}}}, 9), baseline("exact"))),
              testing::ElementsAre("gyr_delay"))
      << "the others deny it";
}

TEST(Engine, DrawsTheTemperatureLawOverTheTemperatureAndTheSpectrumDownToTheNoise) {
  auto config = baseline("exact");
  config.environment.temperature = {.kind = "warm_up", .rise_K = 8.0, .tau_s = 60.0};
  const Answer answer = diagnose(record(config, "gyr_temp_lin", {{"k_radps_per_K", {1e-4, 1e-3, -2e-4}}}, 11), config);
  ASSERT_THAT(names(answer), testing::ElementsAre("gyr_temp_lin"));
  const FindingFigures& f = answer.diagnosis.findings[0].figures;
  EXPECT_EQ(f.channel, "gyr_y");
  EXPECT_EQ(f.driver_label, "temperature, degC");
  ASSERT_GT(f.driver.size(), 1000u);
  EXPECT_NEAR(f.driver.back() - f.driver.front(), 8.0 * (1.0 - std::exp(-100.0 / 60.0)), 0.3);
  EXPECT_NEAR((f.law_at_driver.back() - f.law_at_driver.front()) / (f.driver.back() - f.driver.front()), 1e-3, 5e-5);
  const double white = 2.0 * 1e-3 * 1e-3 / 50.0;  // sd^2 over half of the rate
  ASSERT_EQ(f.psd_after.size(), f.frequency_hz.size());
  double mean_after = 0.0, mean_noise = 0.0;
  for (std::size_t i = 0; i < f.frequency_hz.size(); ++i) {
    mean_after += f.psd_after[i] / static_cast<double>(f.frequency_hz.size());
    mean_noise += f.psd_noise[i] / static_cast<double>(f.frequency_hz.size());
  }
  EXPECT_NEAR(mean_after, white, 0.1 * white);
  EXPECT_NEAR(mean_noise, white, 0.1 * white);
  EXPECT_GT(f.psd_before.front(), 20.0 * f.psd_after.front());
  EXPECT_DOUBLE_EQ(f.autocorrelation_after[0], 1.0);
  EXPECT_GT(f.autocorrelation_before[1], 10.0 * f.autocorrelation_band);
  EXPECT_LT(std::abs(f.autocorrelation_after[1]), 2.0 * f.autocorrelation_band);
}

TEST(Engine, AbstainsOnTooShortARecordingAndSaysSo) {
  auto config = baseline("exact");
  config.motion->duration_s = 8;
  const Answer answer = diagnose(record(config, "", {}, 10), config);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kInsufficientData);
  EXPECT_FALSE(answer.diagnosis.notices.empty());
}

TEST(Response, DelaysASineByItsDelay) {
  const double dt = 0.02, tau = 0.0137, w = 2.0 * M_PI * 1.5;
  Series3 x(2000, 3), expected(2000, 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (int a = 0; a < 3; ++a) {
      x(i, a) = std::sin(w * static_cast<double>(i) * dt + a);
      expected(i, a) = std::sin(w * (static_cast<double>(i) * dt - tau) + a);
    }
  const Series3 y = apply_response(x, RowTimes{dt, {}}, delay_response(tau));
  EXPECT_LT((y - expected).middleRows(200, 1600).cwiseAbs().maxCoeff(), 2e-3);  // the mirrored ends ring a little
}

TEST(Evidence, ChiSquareTailMeetsItsTables) {
  EXPECT_NEAR(chi_square_tail(7.815, 3.0), 0.05, 0.002);
  EXPECT_NEAR(chi_square_tail(21.666, 9.0), 0.01, 0.0005);
}

TEST(Evidence, ANameHasToRemoveMostOfWhatIsRemovableElsewhere) {
  HeldOut h;
  h.removable_share_removed = 0.6, h.share_ci95 = {0.4, 0.8}, h.gain_nats = 200.0;
  EXPECT_TRUE(fails_elsewhere(h, "gyr_asym"));
  EXPECT_FALSE(fails_elsewhere(h, "unknown:w_y*w_z")) << "one term of several";
  h.gain_nats = 20.0;
  EXPECT_FALSE(fails_elsewhere(h, "gyr_asym")) << "the noise leaves as little";
  h.removable_share_removed = 0.75, h.share_ci95 = {0.5, 1.0}, h.gain_nats = 200.0;
  EXPECT_FALSE(fails_elsewhere(h, "gyr_asym"));
  h.removable_share_removed = 0.3, h.share_ci95 = {0.15, 0.45};
  EXPECT_TRUE(fails_elsewhere(h, "unknown:w_y*w_z"));
  EXPECT_FALSE(fails_elsewhere(HeldOut{}, "gyr_asym")) << "nothing was held out";
}

TEST(Summary, JsonHoldsTheContractsKeys) {
  Diagnosis d;
  d.verdict = Verdict::kExplained;
  d.findings.push_back({});
  d.findings[0].p_value = std::nan("");
  const std::string text = to_json(d);
  for (const char* key : {"\"schema\"", "\"verdict\"", "\"findings\"", "\"equivalent\"", "\"held_out\"",
                          "\"configuration\"", "\"residual\""})
    EXPECT_THAT(text, testing::HasSubstr(key));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("nan")));
}

/// Heel strikes that fifty positions a second do not hold leave a residual of the other sign than a clipped one.
TEST(Engine, NothingIsSaturatedByLessThanNothing) {
  sim::SimulationConfig walking = baseline("exact", 60.0);
  walking.motion->kind = "walking";
  for (const std::uint64_t seed : {1U, 2U, 3U})
    EXPECT_THAT(names(diagnose(record(walking, "", {}, seed), walking)), testing::Not(testing::Contains("acc_sat")))
        << seed;
}

}  // namespace
}  // namespace stillpoint::diag

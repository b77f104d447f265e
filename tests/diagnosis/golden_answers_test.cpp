/// Whole answers, word by word and number by number (tests/golden.h). What is right and what is not is asked elsewhere;
/// here an answer that is another one shows.
#include <gtest/gtest.h>

#include <ostream>

#include "diagnosis/improved.h"
#include "diagnosis/summary.h"
#include "tests/diagnosis/simulated.h"
#include "tests/golden.h"

namespace stillpoint::diag {
namespace {

struct Case {
  const char *name, *base, *effects;  ///< of the simulation, and what it leaves out
  const char* simulated = nullptr;    ///< another base for what is believed
};

constexpr char kExact[] =
    "rate_hz: 50\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: 0.0005, bias: [0.01, -0.004, 0.002]}\n"
    "magnetometer: {noise_uT: 0.2, bias: [3, -5, 2]}\nmotion: {kind: hand, duration_s: 50}\n"
    "environment: {temperature: {kind: warm_up, rise_K: 12}, current: {kind: steps}, supply: {discharge_V_per_s: "
    "0.003, resistance_ohm: 0.3}}\n";
constexpr char kCamera[] =
    "rate_hz: 50\naccelerometer: {noise_mps2: 0.006}\ngyroscope: {noise_radps: 0.0004}\nmagnetometer: {noise_uT: 0.2}\n"
    "motion: {kind: walking, duration_s: 50}\nenvironment: {temperature: {kind: warm_up, rise_K: 12}}\n"
    "reference: {kind: mocap, orientation_sd_rad: 0.0006, position_sd_m: 0.0002, band_hz: 5}\n";
constexpr char kAlone[] =
    "rate_hz: 50\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: 0.0005}\nmagnetometer: {noise_uT: 0.2}\n"
    "motion: {kind: rest_poses, duration_s: 80}\nenvironment: {temperature: {kind: warm_up, rise_K: 12}}\n"
    "reference: {kind: none}\n";
constexpr char kIdeal[] =
    "rate_hz: 50\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: 0.0005}\nmagnetometer: {noise_uT: 0.2}\n"
    "motion: {kind: hand, duration_s: 50}\n";
constexpr char kUncalibrated[] =
    "rate_hz: 50\naccelerometer: {noise_mps2: 0.01, bias: [0.2, -0.1, 0.05], matrix: [[1.01, 0, 0.004], [0, 0.99, 0], "
    "[0, 0.002, 1]]}\ngyroscope: {noise_radps: 0.0005}\nmagnetometer: {noise_uT: 0.2}\n"
    "motion: {kind: hand, duration_s: 50}\n";

constexpr Case kCases[] = {
    {"lever", kExact, "{effect: acc_lever, r_m: [0.02, -0.03, 0.01]}"},
    {"delay_in_a_window", kExact, "{effect: gyr_delay, tau_s: 0.008, window_s: [15, 35]}"},
    {"gap_and_temperature", kExact,
     "{effect: sys_gap, n: 3, t0_s: 22}, {effect: gyr_temp_lin, k_radps_per_K: [2e-4, -1e-4, 3e-4]}"},
    {"line", kExact, "{effect: mag_line, b_uT: [0.3, -0.2, 0.4], f_hz: 17.3}"},
    {"clipped", kExact, "{effect: gyr_sat, L_radps: 1.2}"},
    {"walk", kExact, "{effect: gyr_drift, q_radps_per_sqrts: [4e-4, 2e-4, 3e-4]}"},
    {"law", kExact, "{effect: law, sensor: gyr, law: \"norm(w) * (T - 25)\", k: [6e-5, -4e-5, 5e-5]}"},
    {"event", kExact, "{effect: law, sensor: acc, law: \"f * step(t, 26) * step(-t, -26.7)\", k: [0.03, -0.02, 0.01]}"},
    {"camera", kCamera, "{effect: acc_temp_scale, S_per_K: [6e-4, -4e-4, 5e-4]}, {effect: mag_delay, tau_s: 0.02}"},
    {"no_reference", kAlone, "{effect: gyr_temp_lin, k_radps_per_K: [3e-4, -2e-4, 4e-4]}"},
    {"wrong_numbers", kUncalibrated, "", kIdeal},
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::string told(const Case& c) {
  const auto base = test::parsed(std::string(c.base) + "effects: []\n");
  const auto truth = test::parsed(c.base + ("effects: [" + std::string(c.effects)) + "]\n");
  const auto simulation = c.simulated ? test::parsed(std::string(c.simulated) + "effects: []\n") : base;
  const Answer answer = diagnose(test::record(truth, "", {}, 5), simulation);
  return to_text(answer.diagnosis) + io::format_simulation(improved_by(answer, simulation));
}

class GoldenAnswers : public testing::TestWithParam<Case> {};

TEST_P(GoldenAnswers, StandAsTheyWere) {
  stillpoint::test::check_golden_words(std::string("answer_") + GetParam().name, told(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(, GoldenAnswers, testing::ValuesIn(kCases));

}  // namespace
}  // namespace stillpoint::diag

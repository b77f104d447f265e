/// Simulations that somebody damaged: whatever the damage, the reader answers with a configuration that runs or with
/// faults, each at a line and column of the text. The sanitizer builds run this too.
#include <gmock/gmock.h>

#include <cstdio>
#include <random>

#include "io/simulation_yaml.h"
#include "simulation/effect_catalogue.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {
namespace {

constexpr int kMutants = 3000;

/// Every block and every effect once, small enough to run.
std::string good() {
  std::string text =
      "rate_hz: 50\ngravity_mps2: 9.81\nfield_world_uT: [1, 20, -43.5]\n"
      "accelerometer: {bias: [0.1, 0, -0.3], matrix: [[1, 0.5, 0], [0, 1, 0], [0, 0, 2]], noise_mps2: 0.02}\n"
      "gyroscope: {noise_radps: 0.001, noise_axes: [1, 2, 1], rate_hz: 25, bias_instability_radps: 1e-5}\n"
      "magnetometer: {noise_uT: 0.3, noise_band_hz: 5, random_walk_uT_per_sqrts: 0.01}\n"
      "motion: {kind: hand, duration_s: 20, min_bout_s: 4}\n"
      "environment: {temperature: {kind: chamber, rise_K: 30}, current: {kind: steps, high_A: 2},\n"
      "  iron: [{moment_Am2: [1, 0, 0], start_m: [0, 1, 0]}]}\n"
      "timing: {lost_fraction: 0.01}\nreference: {kind: mocap, band_hz: 7}\neffects:\n";
  for (const auto& info : effect_catalogue()) {
    EffectConfig e{.id = info.id, .parameters = {}, .axes = {0, 2}, .sensors = {}, .window_s = std::pair{1.0, 9.0}};
    for (const auto& p : info.parameters) {
      const double value = p.key == "n" ? 3.0 : p.key == "t0_s" ? 5.0 : p.required ? p.typical_low : p.fallback;
      e.parameters[p.key].assign(static_cast<std::size_t>(p.count), value);
    }
    if (info.id == "gyr_coning") e.parameters["p_rad"] = {0.0, 1.0, 2.5};
    if (info.takes_sensors()) e.sensors = {Sensor::kGyr};
    text += "  - " + io::format_effect(e) + "\n";
  }
  return text;
}

/// A word of the text replaced by one that a careless or hostile hand would write, or bytes flipped, cut or repeated.
std::string damaged(std::string text, std::mt19937& random) {
  static const std::vector<std::string> kWords{"nan",
                                               ".nan",
                                               "inf",
                                               "-inf",
                                               "1e999",
                                               "-1",
                                               "0",
                                               "1e308",
                                               "-1e-308",
                                               "9999999999999999999",
                                               "''",
                                               "~",
                                               "null",
                                               "[]",
                                               "{}",
                                               "[[[[1]]]]",
                                               "[1, 2",
                                               "{a: b}",
                                               "true",
                                               "x",
                                               "\"",
                                               "\t",
                                               "!!binary",
                                               "&a",
                                               "*a",
                                               "#",
                                               ": ",
                                               "- ",
                                               "---",
                                               "?",
                                               "|",
                                               "é",
                                               std::string(1, '\0'),
                                               std::string(300, '['),
                                               std::string(5000, 'a')};
  const auto below = [&random](std::size_t n) { return n == 0 ? 0 : random() % n; };
  static const std::vector<std::string> kNumbers{"0.5", "2", "1e-3", "-0.25", "7", "1e5", "0", "-3e8", "1e-9", "40"};
  for (std::size_t edits = 1 + below(2); edits > 0 && !text.empty(); --edits) {
    std::size_t at = below(text.size());
    if (below(2) == 0) {  // another number where one stands
      at = text.find_first_of("0123456789", at);
      const std::size_t end = text.find_first_of(" ,]}\n", at);
      if (at == std::string::npos || end == std::string::npos) continue;
      text.replace(at, end - at, kNumbers[below(kNumbers.size())]);
    } else if (below(3) > 0) {
      while (at > 0 && std::string(" :,[]{}\n").find(text[at - 1]) == std::string::npos) --at;
      const std::size_t end = text.find_first_of(" :,[]{}\n", at);
      text.replace(at, (end == std::string::npos ? text.size() : end) - at, kWords[below(kWords.size())]);
    } else if (below(2) == 0) {
      text.erase(at, 1 + below(30));
    } else {
      text.insert(at, text.substr(below(text.size()), 1 + below(60)));
    }
  }
  return text;
}

void expect_located(const std::string& message, const std::string& text) {
  const auto lines = 1 + std::count(text.begin(), text.end(), '\n') + std::count(text.begin(), text.end(), '\r');
  std::istringstream faults(message);
  std::string line;
  ASSERT_TRUE(std::getline(faults, line));
  const std::string head = line.substr(0, 200);
  long row = 0, column = 0;
  char what = 0;
  ASSERT_EQ(std::sscanf(head.c_str(), "m.yaml:%ld:%ld: %c", &row, &column, &what), 3) << head;
  ASSERT_GE(row, 1) << head;
  ASSERT_LE(row, lines) << head;
  ASSERT_GE(column, 1) << head;
}

TEST(Mutation, TheSimulationReaderNamesThePlaceOfEveryDamage) {
  const std::string text = good();
  ASSERT_TRUE(io::parse_simulation(text, "m.yaml")) << io::parse_simulation(text, "m.yaml").error().message;
  std::mt19937 random(1);
  int read = 0, refused = 0;
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = damaged(text, random);
    auto config = io::parse_simulation(mutant, "m.yaml");
    if (!config) {
      ++refused;
      expect_located(config.error().message, mutant);
      if (HasFatalFailure()) FAIL() << "mutant " << i;
      continue;
    }
    ++read;
    if (read % 5 != 0 || !config->motion) continue;  // running all would take too long
    // What the reader lets pass, the simulator can run.
    config->rate_hz = std::min(config->rate_hz, 50.0);
    const std::shared_ptr<const Motion> motion = make_motion(*config->motion, 1);
    Simulator simulator(*config, motion, 1);
    SimulatedSample row;
    for (int k = 0; k < 100 && simulator.next(row); ++k)
      for (const auto slot : {&RawSample::acc_mps2, &RawSample::gyr_radps, &RawSample::mag_uT})
        ASSERT_TRUE(vec(row.sample.*slot).allFinite()) << "mutant " << i << " row " << k << "\n" << mutant;
  }
  EXPECT_GT(read, kMutants / 10) << "the damage is so great that nothing is tested";
  EXPECT_GT(refused, kMutants / 5);
}

TEST(Hostile, ValuesGetAClearAnswer) {
  const auto answer = [](const std::string& more) {
    const auto c = io::parse_simulation("accelerometer: {noise_mps2: 0.02}\n" + more, "h.yaml");
    return c ? "accepted" : c.error().message;
  };
  using ::testing::StartsWith;
  EXPECT_THAT(answer("rate_hz: 0\n"), StartsWith("h.yaml:2:10: 'rate_hz' is 0, allowed is 0.1 to 100000"));
  EXPECT_THAT(answer("rate_hz: .nan\n"), StartsWith("h.yaml:2:10: 'rate_hz' is .nan; it must be a finite number"));
  EXPECT_THAT(answer("rate_hz: -5\n"), StartsWith("h.yaml:2:10: 'rate_hz' is -5"));
  EXPECT_THAT(answer("motion: {duration_s: 1e9}\n"), StartsWith("h.yaml:2:22: 'duration_s' is 1e9, allowed is"));
  EXPECT_THAT(answer("motion: {duration_s: -1}\n"), StartsWith("h.yaml:2:22: 'duration_s' is -1"));
  EXPECT_THAT(answer("motion: {duration_s: 1e6, min_bout_s: 0.5, max_bout_s: 0.5, min_rest_s: 0}\n"),
              StartsWith("h.yaml:2:9: 2000000 bouts may come"));
  EXPECT_THAT(answer("effects: [{effect: acc_quant, q_mps2: 0}]\n"),
              StartsWith("h.yaml:2:39: 'q_mps2' must be greater"));
  EXPECT_THAT(answer("effects: [{effect: sys_jitter, sd_s: -1}]\n"), StartsWith("h.yaml:2:38: 'sd_s' must be 0 or"));
  std::string frames = "effects:\n";
  for (int i = 0; i < 33; ++i) frames += "  - {effect: ref_frame, phi_rad: 0.01}\n";
  EXPECT_THAT(answer(frames), ::testing::HasSubstr("33 entries of ref_frame; 32 at most"));
  EXPECT_THAT(answer("effects: [{effect: acc_quad, k2_per_mps2: 1e300}]\n"),
              StartsWith("h.yaml:2:43: 'k2_per_mps2' is 1e300"));
}

}  // namespace
}  // namespace stillpoint::sim

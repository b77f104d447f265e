/// What is said of every mistake in a simulation's YAML, and how a simulation that sets everything is written.
#include <gtest/gtest.h>

#include "io/simulation_yaml.h"
#include "tests/golden.h"

namespace stillpoint::io {
namespace {

TEST(GoldenYaml, EveryMistakeHasItsPlaceAndItsWords) {
  std::ifstream file(in_source("tests/golden/mistakes_simulation.yaml"));
  const auto config = parse_simulation({std::istreambuf_iterator<char>(file), {}}, "mistakes.yaml");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().kind, ErrorKind::kBadConfig);
  test::check_golden_text("mistakes_simulation", config.error().message + "\n");
}

TEST(GoldenYaml, ASimulationThatSetsEverythingIsWrittenInFull) {
  constexpr char kEverything[] =
      "rate_hz: 50\ngravity_mps2: 9.81\nfield_world_uT: [1, 20, -43.5]\n"
      "accelerometer: {bias: [1, 2, 3], matrix: [[1, 4, 5], [6, 2, 7], [8, 9, 3]], noise_mps2: 1, noise_axes: [1, 2, "
      "3],"
      " noise_band_hz: 4, bias_instability_mps2: 5, random_walk_mps2_per_sqrts: 6, rate_hz: 7}\n"
      "gyroscope: {noise_radps: 1, bias_instability_radps: 5, random_walk_radps_per_sqrts: 6}\n"
      "magnetometer: {noise_uT: 1, bias_instability_uT: 5, random_walk_uT_per_sqrts: 6}\n"
      "effects:\n  - {effect: acc_size, r_m: [[1, 2, 3], [4, 5, 6], [7, 8, 9]], axes: [x, z], window_s: [1, 2]}\n"
      "  - {effect: acc_quad, k2_per_mps2: 3, axes: [y]}\n"
      "  - {effect: sys_dup, fraction: 0.1, sensors: [gyr, mag]}\n"
      "  - {effect: law, sensor: gyr, law: \"norm(w) * (T - 25)\", k: 2, tau_s: 3, from_s: 4}\n"
      "  - {effect: law, sensor: mag, law: \"w\", matrix: [[1, 2, 3], [4, 5, 6], [7, 8, 9]], to_s: 4}\n"
      "  - {effect: table, sensor: acc, driver: \"T\", x: [1, 2, 3], y: [[1, 2, 3], [4, 5, 6], [7, 8, 9]], clamp: "
      "true, from_s: 1, to_s: 2}\n"
      "motion: {kind: rest_poses, duration_s: 20, min_bout_s: 2, max_bout_s: 3, min_rest_s: 4, max_rest_s: 5, "
      "rate_radps: 6, sway_m: 7, poses: 8, move_s: 9, speed_mps: 10, vibration_hz: 11, vibration_mps2: 12}\n"
      "environment: {temperature: {kind: chamber, start_degC: 1, rise_K: 2, tau_s: 3, period_s: 4, noise_K: 5}, "
      "current: {kind: steps, high_A: 1, min_hold_s: 2, max_hold_s: 3, noise_A: 4}, "
      "supply: {start_V: 1, discharge_V_per_s: 0.5, resistance_ohm: 2, noise_V: 3}, latitude_rad: 1, height_m: 2, "
      "iron: [{moment_Am2: [1, 2, 3], start_m: [4, 5, 6], velocity_mps: [7, 8, 9]}, {moment_Am2: [0, 0, 1]}]}\n"
      "timing: {lost_fraction: 0.01}\n"
      "reference: {kind: mocap, orientation_sd_rad: 0.1, position_sd_m: 0.2, band_hz: 7}\n";
  const auto config = parse_simulation(kEverything, "a");
  ASSERT_TRUE(config) << config.error().message;
  const std::string text = format_simulation(*config);
  test::check_golden_text("everything_simulation", text);
  const auto again = parse_simulation(text, "b");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(format_simulation(*again), text);
}

}  // namespace
}  // namespace stillpoint::io

#include "io/simulation_yaml.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "simulation/effect_catalogue.h"
#include "simulation/simulator.h"
#include "tests/source_folder.h"

namespace stillpoint::sim {
namespace {

using ::testing::HasSubstr;

const std::string kSensor = "accelerometer: {noise_mps2: 0.02}\n";

std::string faults_of(const std::string& text) {
  const auto config = io::parse_simulation(text, "s.yaml");
  return config ? "" : config.error().message;
}

TEST(SimulationYaml, NamesEveryMistakeWithLineAndColumn) {
  EXPECT_THAT(faults_of(kSensor + "effects:\n  - {effect: gyr_tmp_lin, k_radps_per_K: 1}\n"),
              HasSubstr("s.yaml:3:14: unknown effect 'gyr_tmp_lin'; did you mean 'gyr_temp_lin'?"));
  EXPECT_THAT(faults_of(kSensor + "effects:\n  - {effect: gyr_gsens, G_radps_per_mps2: [1, 2, 3]}\n"),
              HasSubstr("s.yaml:3:43: 'G_radps_per_mps2' has 3 numbers, gyr_gsens takes 9"));
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: gyr_delay}]\n"),
              HasSubstr("gyr_delay needs 'tau_s' (one number, s)"));
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: gyr_lpf, tau_s: -1}]\n"),
              HasSubstr("'tau_s' must be greater than 0"));
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: sys_gap, n: 2.5, t0_s: 1}]\n"), HasSubstr("whole number"));
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: sys_gap, n: 0, t0_s: 1}]\n"), HasSubstr("whole number"));
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: mag_hold, n: 0.5}]\n"), HasSubstr("1 to 1e6 samples"));
  EXPECT_EQ(faults_of(kSensor + "effects: [{effect: mag_hold, n: 2.8}, {effect: sys_gap, n: -4, t0_s: 1}]\n"), "");
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: acc_quad, k2_per_mps2: 1, axes: [x, q]}]\n"),
              HasSubstr("'q' is not an axis"));
  EXPECT_THAT(faults_of(kSensor + "effects: [{effect: acc_quad, k2_per_mps2: 1, window_s: [5, 5]}]\n"),
              HasSubstr("must start before it ends"));
  EXPECT_THAT(faults_of("rate_hz: 100\n"), HasSubstr("no sensor"));
  EXPECT_THAT(faults_of("accelerometer: {matrix: [[1,0,0],[0,1,0],[0,0,0]]}\n"), HasSubstr("cannot be inverted"));
  EXPECT_THAT(faults_of(kSensor + "motion: {kind: hnd}\n"), HasSubstr("did you mean 'hand'?"));
  EXPECT_THAT(faults_of(kSensor + "environment: {temperature: {kind: warm}}\n"), HasSubstr("'warm' is not a kind"));
  EXPECT_THAT(faults_of(kSensor + "gravity_mps: 9.8\n"), HasSubstr("did you mean 'gravity_mps2'?"));
}

TEST(SimulationYaml, SensorsAreChosenWhereAnEffectActsOnSeveral) {
  EXPECT_THAT(faults_of(kSensor + "effects:\n  - {effect: mag_delay, tau_s: 0.01, sensors: [acc]}\n"),
              HasSubstr("s.yaml:3:47: 'sensors' has no meaning for mag_delay"));
  EXPECT_THAT(faults_of(kSensor + "effects:\n  - {effect: sys_skew, eps_ppm: 50, sensors: [acc, x]}\n"),
              HasSubstr("s.yaml:3:52: 'x' is not a sensor; use acc, gyr or mag"));
  EXPECT_THAT(faults_of(kSensor + "effects:\n  - {effect: sys_skew, eps_ppm: 50, sensors: [acc, acc]}\n"),
              HasSubstr("sensor 'acc' stands twice"));
  EXPECT_EQ(faults_of(kSensor + "effects:\n  - {effect: sys_skew, eps_ppm: 5, sensors: [acc], axes: [x]}\n"), "");
}

TEST(SimulationYaml, ReportsAllMistakesAtOnce) {
  const std::string faults = faults_of("rate_hz: -1\naccelerometer: {noise: 1}\neffects: [{effect: nonsense}]\n");
  EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 2);
}

TEST(SimulationYaml, WritesWhatReadsBackToTheSame) {
  const std::string text =
      "rate_hz: 50\ngravity_mps2: 9.81\nfield_world_uT: [1, 20, -43.5]\n"
      "gyroscope: {bias: [0.1, 0, -0.3], matrix: [[1, 0.5, 0], [0, 1, 0], [0, 0, 2]], noise_radps: 0.001, "
      "noise_axes: [1, 2, 1], rate_hz: 25}\n"
      "effects:\n  - {effect: acc_size, r_m: [[1, 2, 3], [4, 5, 6], [7, 8, 9]], axes: [x, z], window_s: [1, 2]}\n"
      "  - {effect: gyr_delay, tau_s: 0.002}\n  - {effect: sys_dup, fraction: 0.1, sensors: [gyr, mag]}\n"
      "motion: {kind: drone, duration_s: 20}\n"
      "environment: {temperature: {kind: chamber, rise_K: 30}, iron: [{moment_Am2: [1, 0, 0], start_m: [0, 1, 0]}]}\n"
      "timing: {lost_fraction: 0.01}\nreference: {kind: mocap, band_hz: 7}\n";
  const auto once = io::parse_simulation(text, "a");
  ASSERT_TRUE(once) << once.error().message;
  const auto twice = io::parse_simulation(io::format_simulation(*once), "b");
  ASSERT_TRUE(twice) << twice.error().message;
  EXPECT_EQ(io::format_simulation(*once), io::format_simulation(*twice));
  EXPECT_EQ(twice->effects[0].parameters.at("r_m")[5], 6.0);
  EXPECT_EQ(twice->effects[0].axes, (std::vector<int>{0, 2}));
  EXPECT_EQ(twice->effects[2].sensors, (std::vector{Sensor::kGyr, Sensor::kMag}));
  EXPECT_EQ(twice->environment.temperature.rise_K, 30.0);
  EXPECT_EQ(twice->environment.iron.at(0).start_m.y(), 1.0);
  EXPECT_EQ(twice->gyroscope->rate_hz, 25.0);
  EXPECT_FALSE(twice->accelerometer);
}

TEST(SimulationYaml, EveryEffectOfTheCatalogueReadsBack) {
  for (const auto& info : effect_catalogue()) {
    EffectConfig e;
    e.id = info.id;
    for (const auto& p : info.parameters) e.parameters[p.key].assign(static_cast<std::size_t>(p.count), 2.0);
    if (e.parameters.contains("fraction")) e.parameters["fraction"] = {0.5};
    if (e.parameters.contains("zeta")) e.parameters["zeta"] = {0.1};
    if (e.parameters.contains("side")) e.parameters["side"] = {1.0, -1.0, 0.0};
    if (e.parameters.contains("hidden")) e.parameters["hidden"] = {1.0};
    const auto back = io::parse_simulation(kSensor + "effects:\n  - " + io::format_effect(e) + "\n", "x");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->effects[0].parameters, e.parameters);
  }
}

TEST(SimulationYaml, ShippedSimulationsRun) {
  for (const auto& file : std::filesystem::directory_iterator(in_source("configs"))) {
    const std::string name = file.path().filename();
    if (!name.starts_with("sim_")) continue;
    auto config = io::read_simulation(file.path());
    ASSERT_TRUE(config) << config.error().message;
    if (!config->motion) continue;
    config->motion->duration_s = std::min(config->motion->duration_s, 20.0);
    EXPECT_GT(simulate(*config, 1).size(), 100U) << name;
  }
}

TEST(EffectCatalogue, PageInTheDocumentationIsTheTable) {
  std::ifstream file(in_source("docs/effects.md"));
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(page, effect_catalogue_page()) << "write it anew: stillpoint effects > docs/effects.md";
}

TEST(Gravity, FollowsLatitudeAndHeight) {
  EXPECT_NEAR(normal_gravity_mps2(0.0, 0.0), 9.7803253359, 1e-9);
  EXPECT_NEAR(normal_gravity_mps2(1.5707963267948966, 0.0), 9.8321849378, 1e-8);
  EXPECT_NEAR(normal_gravity_mps2(0.8, 0.0) - normal_gravity_mps2(0.8, 1000.0), 3.086e-3, 1e-5);
  const auto config = io::parse_simulation(kSensor + "environment: {latitude_rad: 0, height_m: 0}\n", "x");
  EXPECT_NEAR(config->gravity_mps2, 9.7803253359, 1e-9);
}

}  // namespace
}  // namespace stillpoint::sim

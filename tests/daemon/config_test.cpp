#include <fmt/format.h>

#include <filesystem>

#include "io/config.h"
#include "io/simulation_yaml.h"
#include "tests/apps/apps_testing.h"
#include "tests/source_folder.h"

namespace stillpoint::io {
namespace {

std::string faults(const std::string& text) {
  const auto config = parse_config(text, "f.yaml");
  if (config) return "no fault";
  EXPECT_EQ(config.error().kind, ErrorKind::kBadConfig);
  return config.error().message;
}

TEST(DaemonConfig, EveryShippedFileIsWithoutFault) {
  std::size_t daemons = 0;
  for (const auto& entry : std::filesystem::directory_iterator(in_source("configs"))) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".yaml" || name.starts_with("sim_")) continue;
    const auto config = read_config(entry.path().string());
    EXPECT_TRUE(config.has_value()) << (config ? "" : config.error().message);
    ++daemons;
  }
  EXPECT_GE(daemons, 3U);
}

TEST(DaemonConfig, PrintedItReadsBackToTheSame) {
  const auto config = parse_config(
      "source: {kind: simulation, file: /a.yaml, speed: 3.5}\noutput: {world_frame: ned, mount: \"+y -x +z\"}\n"
      "compensate: [{effect: acc_lever, r_m: [0.1, 0.2, 0.3]}]\nrest: {window_s: 1.25}\n"
      "sensor: {id: \"it's a \\\"quoted\\\" #1: {x}\"}\n",
      "f.yaml");
  ASSERT_TRUE(config.has_value()) << config.error().message;
  const std::string text = print_config(*config);
  const auto again = parse_config(text, "printed.yaml");
  ASSERT_TRUE(again.has_value()) << again.error().message << text;
  EXPECT_EQ(print_config(*again), text);
}

TEST(DaemonConfig, PrintedWithoutASourceItReadsBackToo) {
  const auto config = parse_config("sensor: {id: a}", "f.yaml");
  ASSERT_TRUE(config.has_value()) << config.error().message;
  const std::string text = print_config(*config);
  EXPECT_NE(text.find("#   file: "), std::string::npos) << text;
  const auto again = parse_config(text, "printed.yaml");
  ASSERT_TRUE(again.has_value()) << again.error().message << text;
  EXPECT_EQ(print_config(*again), text);
}

TEST(DaemonConfig, PrintedItNamesItsSourceFromAnyFolder) {
  const auto config = parse_config("source: {kind: recording, file: a.csv}", "folder/f.yaml");
  ASSERT_TRUE(config.has_value()) << config.error().message;
  const auto again = parse_config(print_config(*config), "/elsewhere/printed.yaml");
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(again->source.file, std::filesystem::absolute("folder/a.csv").string());
}

TEST(DaemonConfig, NamesEveryFaultAtItsPlaceNotOnlyTheFirst) {
  const std::string all = faults(
      "source: {kind: recordin, file: a.csv}\nrest: {window_s: .nan}\nattitude: {gyr_noise_radps_rtHz: fast}\n"
      "stale_after_s: -1\nsensr: {}\noutput: {world_frame: end}\n");
  for (const char* fault :
       {"f.yaml:1:16: 'kind' cannot be 'recordin'; did you mean 'recording'?", "f.yaml:2:18: 'window_s'",
        "f.yaml:3:34: 'gyr_noise_radps_rtHz' must be a number", "f.yaml:4:16: 'stale_after_s' is -1",
        "f.yaml:5:1: unknown key 'sensr'; did you mean 'sensor'?", "f.yaml:6:23: 'world_frame'"})
    EXPECT_NE(all.find(fault), std::string::npos) << fault << "\nnot in\n" << all;
}

TEST(DaemonConfig, RefusesTwoTopicsOfOneName) {
  EXPECT_NE(faults("dds: {attitude_topic: a, raw_topic: a}").find("two topics are named 'a'"), std::string::npos);
  EXPECT_EQ(faults("dds: {raw_topic: ''}"), "no fault");
}

TEST(DaemonConfig, RefusesAMirroredMountAndNamesTheNearestRotation) {
  EXPECT_NE(faults("output: {mount: \"+x +y -z\"}").find("mirrors"), std::string::npos);
  EXPECT_NE(faults("output: {mount: \"+x +x +z\"}").find("is not a rotation"), std::string::npos);
  EXPECT_NE(faults("output: {mount: \"+x +y\"}").find("three signed axes"), std::string::npos);
  EXPECT_EQ(faults("output: {mount: \"+y -x +z\"}"), "no fault");
}

TEST(DaemonConfig, TakesOnlyEffectsThatCanBeTakenOutInRealTime) {
  EXPECT_NE(faults("compensate: [{effect: acc_lpf, tau_s: 0.01}]").find("cannot be taken out"), std::string::npos);
  EXPECT_NE(faults("compensate: [{effect: gyr_gsen}]").find("gyr_gsens"), std::string::npos);
  const auto config =
      parse_config("compensate: [{effect: gyr_gsens, G_radps_per_mps2: [1e-4,0,0, 0,2e-4,0, 0,0,3e-4]}]", "f.yaml");
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_EQ(stages_params(*config).compensation.gyr_gsens.diagonal(), Vec3(1e-4, 2e-4, 3e-4));
}

TEST(DaemonConfig, TakesLawsOfWhatTheStagesKnowAtThatMoment) {
  for (const char* law : {"w * (T - 25)", "norm(w) * f_x", "m^2"})
    EXPECT_EQ(faults(fmt::format("compensate: [{{effect: law, sensor: gyr, law: \"{}\", k: [1e-4, 0, 0]}}]", law)),
              "no fault")
        << law;
  for (const char* law : {"lag(w, 2)", "d(w)", "I * w", "t", "motor_rpm"})
    EXPECT_NE(faults(fmt::format("compensate: [{{effect: law, sensor: gyr, law: \"{}\", k: [1e-4, 0, 0]}}]", law))
                  .find(fmt::format("the law '{}' cannot be taken out", law)),
              std::string::npos)
        << law;
  const auto config =
      parse_config("compensate: [{effect: law, sensor: mag, law: \"m * (T - 25)\", k: [1e-4, 2e-4, 3e-4]}]", "f.yaml");
  ASSERT_TRUE(config.has_value()) << config.error().message;
  const auto compensation = stages_params(*config).compensation;
  ASSERT_TRUE(compensation.laws);
  ASSERT_EQ(compensation.laws->size(), 1U);
  EXPECT_TRUE(compensation.any);
  EXPECT_EQ(compensation.laws->front().of, &pipeline::Momentary::field);
  const pipeline::Momentary now{.field = {10.0, 20.0, 30.0}, .temp_degC = 35.0};
  EXPECT_TRUE(compensation.laws->front().delta(now).isApprox(Vec3(0.01, 0.04, 0.09)));
}

TEST(DaemonConfig, SaysBeforehandWhichEffectsItWillTake) {
  for (const char* entry : {"{effect: acc_lpf, tau_s: 0.01}", "{effect: gyr_asym, k: 1e-3}",
                            "{effect: mag_delay, tau_s: 0.01}", "{effect: gyr_asym, k: 1e-3, window_s: [1, 2]}",
                            "{effect: law, sensor: gyr, law: \"f_x * (T - 25)\", k: [1e-4, 0, 0]}",
                            "{effect: law, sensor: gyr, law: \"lag(f_x, 2)\", k: [1e-4, 0, 0]}"}) {
    const auto simulation = parse_simulation(fmt::format("{{gyroscope: {{}}, accelerometer: "
                                                         "{{}}, magnetometer: {{}}, effects: [{}]}}",
                                                         entry),
                                             "s.yaml");
    ASSERT_TRUE(simulation.has_value()) << simulation.error().message;
    EXPECT_EQ(can_be_compensated(simulation->effects.at(0)),
              faults(fmt::format("compensate: [{}]", entry)) == "no fault")
        << entry;
  }
}

TEST(DaemonConfig, RefusesASensorIdThatWouldLeaveTheStateFolder) {
  EXPECT_NE(faults("sensor: {id: ../../etc/passwd}").find("'id'"), std::string::npos);
  EXPECT_NE(faults("sensor: {id: \"\"}").find("'id'"), std::string::npos);
  EXPECT_NE(faults("sensor: {id: \"a\\0b\"}").find("'id'"), std::string::npos);
  EXPECT_NE(faults("sensor: {id: " + std::string(101, 'a') + "}").find("'id'"), std::string::npos);
}

TEST(DaemonConfig, RefusesAMatrixWithoutAnInverseAndAnUnknownModel) {
  EXPECT_EQ(faults("sensor: {gyroscope: {matrix: [[1,0,0],[0,1,0],[1,1,0]]}}").substr(0, 30),
            "f.yaml:1:30: 'matrix' takes di");
  EXPECT_NE(faults("sensor: {accelerometer: {matrix: [[0,0,0],[0,0,0],[0,0,0]]}}").find("inverse"), std::string::npos);
  EXPECT_EQ(faults("calibration: {online: {temperature_model: cell}}"),
            "f.yaml:1:43: temperature_model is 'cell'; it must be none, cells or polynomial");
}

}  // namespace
}  // namespace stillpoint::io

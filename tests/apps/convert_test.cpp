/// `stillpoint convert`: files as the other programs write them, what comes out of them, and what is said to be lost.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// An <imu> as in Gazebo's examples: the sign of bias_mean is drawn at each start.
constexpr auto kSdf = R"(<?xml version="1.0"?>
<sdf version="1.9"><model name="m"><link name="l"><sensor name="imu" type="imu"><update_rate>250</update_rate><imu>
  <orientation_reference_frame><localization>ENU</localization></orientation_reference_frame>
  <angular_velocity>
    <x><noise type="gaussian"><mean>0.01</mean><stddev>0.002</stddev></noise></x>
    <y><noise type="gaussian"><mean>-0.02</mean><stddev>0.002</stddev></noise></y>
    <z><noise type="gaussian"><mean>0</mean><stddev>0.002</stddev><bias_mean>7.5e-06</bias_mean></noise></z>
  </angular_velocity>
  <linear_acceleration>
    <x><noise type="gaussian"><mean>0.1</mean><stddev>0.017</stddev><precision>0.0025</precision></noise></x>
    <y><noise type="gaussian"><mean>0</mean><stddev>0.017</stddev><precision>0.0025</precision></noise></y>
    <z><noise type="gaussian"><mean>0</mean><stddev>0.017</stddev><precision>0.0025</precision></noise></z>
  </linear_acceleration>
</imu></sensor></link></model></sdf>
)";

/// What imuSensor's loadparams reads, one part a name.
constexpr auto kMatlab = R"({"GenericLowCost": {
  "Accelerometer": {"ConstantBias": [0.19, 0.0, 0.0], "NoiseDensity": [0.0012, 0.0012, 0.0012], "Resolution": 0.0024,
                    "MeasurementRange": 156.9},
  "Gyroscope": {"ConstantBias": [0.01, 0.02, 0.03], "NoiseDensity": [8.7e-05, 8.7e-05, 8.7e-05],
                "TemperatureBias": [1e-4, 2e-4, 3e-4], "AccelerationBias": [1e-5, 2e-5, 3e-5]}}}
)";

constexpr auto kKalibr = R"(rostopic: /imu0
update_rate: 200.0
accelerometer_noise_density: 0.002
accelerometer_random_walk: 0.0
gyroscope_noise_density: 0.00016
gyroscope_random_walk: 0.0
T_i_b: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
time_offset: 0.003
)";

/// Saved by QGroundControl: vehicle, component, name, value, type.
constexpr auto kPx4 =
    "# Onboard parameters for Vehicle "
    "1\n1\t1\tTC_G_ENABLE\t1\t6\n1\t1\tTC_G0_TMIN\t10.0\t9\n1\t1\tTC_G0_TREF\t35.0\t9\n"
    "1\t1\tTC_G0_X0_0\t0.01\t9\n1\t1\tTC_G0_X1_0\t0.0005\t9\n1\t1\tTC_G1_TREF\t35.0\t9\n";

class Convert : public ToolInFolder {
 protected:
  /// Writes `text` as `name` and converts it; what came out is in `out_`.
  int convert(const std::string& name, const std::string& text, const std::string& options) {
    write_file(folder_ / name, text);
    const int code = tool("convert " + name + " " + options + " --output - > out");
    out_ = read_file(folder_ / "out");
    return code;
  }
  std::string out_;
};

TEST_F(Convert, EachProgramsFileIsSeenAndBecomesASimulationWithoutFault) {
  const std::vector<std::array<std::string, 4>> cases{
      {"robot.sdf", kSdf, "bias: [0.01, -0.02, 7.5e-06]", "lost: angular_velocity z: the sign of bias_mean"},
      {"part.json", kMatlab, "effect: gyr_gsens", "lost: the rate: MATLAB keeps it outside"},
      {"imu.yaml", kKalibr, "rate_hz: 200", "lost: time_offset"},
      {"vehicle.params", kPx4, "effect: gyr_temp_lin", "lost: the parameters of further sensors (TC_A1_, ...)"}};
  for (const auto& [name, text, holds, lost] : cases) {
    ASSERT_EQ(convert(name, text, "--to stillpoint"), 0) << name << told_;
    EXPECT_THAT(out_, AllOf(HasSubstr(holds), Not(HasSubstr("lost")))) << name;
    EXPECT_THAT(told_, HasSubstr(lost)) << name;
    write_file(folder_ / "sim.yaml", out_);
    EXPECT_EQ(tool("check sim.yaml > checked"), 0) << name << read_file(folder_ / "checked") << out_;
  }
}

TEST_F(Convert, WhatWentOutComesBackAsItWas) {
  write_file(folder_ / "mine.yaml",
             "rate_hz: 200\naccelerometer: {bias: [0.1, -0.2, 0.3], noise_mps2: 0.02}\n"
             "gyroscope: {bias: [0.01, 0.02, -0.01], noise_radps: 0.002}\n"
             "effects: [{effect: gyr_temp_lin, k_radps_per_K: [1.0e-4, 2.0e-4, -1.0e-4]}]\n");
  // format, what it keeps of the gyroscope, what it says is lost
  const std::vector<std::array<std::string, 3>> cases{
      {"sdf", "bias: [0.01, 0.02, -0.01]", "lost: effect gyr_temp_lin\n"},
      {"gazebo", "bias: [0.01, 0.02, -0.01]", "lost: effect gyr_temp_lin\n"},
      {"kalibr", "noise_radps: 0.002", "lost: gyroscope: bias, which Kalibr estimates anew\n"},
      {"px4", "k_radps_per_K: [0.0001, 0.0002, -0.0001]", "lost: gyroscope: noise\n"},
      {"matlab", "k_radps_per_K: [0.0001, 0.0002, -0.0001]", ""},
      {"sensor", "bias: [0.01, 0.02, -0.01]", "lost: gyroscope: noise"},
      {"imu_calib", "bias: [0.1, -0.2, 0.3]", "lost: gyroscope\n"}};
  for (const auto& [format, keeps, lost] : cases) {
    ASSERT_EQ(tool("convert mine.yaml --to " + format + " --output there"), 0) << format << told_;
    EXPECT_THAT(told_, HasSubstr(lost)) << format;
    ASSERT_EQ(tool("convert there --from " + format + " --to stillpoint --output back.yaml"), 0) << format << told_;
    EXPECT_THAT(read_file(folder_ / "back.yaml"), HasSubstr(keeps)) << format << read_file(folder_ / "there");
  }
}

TEST_F(Convert, KalibrsDensityIsWhatTheSimulatedSensorShows) {
  ASSERT_EQ(convert("imu.yaml", kKalibr, "--to stillpoint"), 0) << told_;
  write_file(folder_ / "rest.yaml",
             out_ + "motion: {kind: hand, duration_s: 400, min_rest_s: 100000, max_rest_s: 100000}\n");
  ASSERT_EQ(tool("simulate --simulation rest.yaml --output rest.csv"), 0) << told_ << out_;
  ASSERT_EQ(tool("noise --recording rest.csv --kalibr seen.yaml > out"), 0) << told_;
  const std::string seen = read_file(folder_ / "seen.yaml");
  for (const auto& [key, density] :
       {std::pair{"accelerometer_noise_density: ", 0.002}, {"gyroscope_noise_density: ", 0.00016}}) {
    const auto at = seen.find(key);
    ASSERT_NE(at, std::string::npos) << seen;
    EXPECT_NEAR(std::stod(seen.substr(at + std::string(key).size())) / density, 1.0, 0.1) << key;
  }
}

TEST_F(Convert, EveryMistakeHasItsCodeAndItsPlace) {
  EXPECT_EQ(convert("robot.sdf", kSdf, "--to webots"), 64);
  EXPECT_THAT(told_, HasSubstr("webots: no format; known are stillpoint, sdf, matlab, kalibr, px4, sensor, imu_calib"));
  EXPECT_EQ(convert("notes.txt", "my sensor is good\n", "--to sdf"), 65);
  EXPECT_THAT(told_, HasSubstr("notes.txt: its format is not seen; say --from"));
  EXPECT_EQ(convert("broken.sdf", "<imu>\n<angular", "--to stillpoint"), 65);
  EXPECT_THAT(told_, HasSubstr("broken.sdf:2: no XML"));
  EXPECT_EQ(convert("imu.yaml", "gyroscope_noise_density: many\nupdate_rate: 200\n", "--to stillpoint"), 65);
  EXPECT_THAT(told_, HasSubstr("imu.yaml:1:26: "));
  EXPECT_EQ(convert("part.json", "{\"Gyroscope\": {\"ConstantBias\": \"none\", \"NoiseType\": 3}}", "--to stillpoint"),
            65);
  EXPECT_THAT(told_, HasSubstr("part.json: not as loadparams writes it"));
  EXPECT_EQ(convert("mine.yaml", "rate_hz: 200\ngyroscop: {}\n", "--to sdf"), 78);
  EXPECT_THAT(told_, HasSubstr("did you mean 'gyroscope'?"));
  EXPECT_EQ(convert("compass.yaml", "magnetometer: {noise_uT: 0.3}\n", "--to px4"), 65);
  EXPECT_THAT(told_, AllOf(HasSubstr("lost: magnetometer\n"), HasSubstr("compass.yaml: px4 can hold nothing of it")));
  EXPECT_EQ(out_, "");
  EXPECT_EQ(tool("convert nothing.yaml --to sdf --output out.sdf"), 66);
  EXPECT_EQ(tool("convert imu.yaml --to sdf"), 64);
  write_file(folder_ / "good.yaml", kKalibr);
  EXPECT_EQ(tool("convert good.yaml --to sdf --output no/folder.sdf"), 73);
}

}  // namespace
}  // namespace stillpoint::test

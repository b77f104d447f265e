/// Parameters of simulated sensors through the formats of other programs: what they hold comes back, what they do not
/// hold is told.
#include "exchange/parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "io/simulation_yaml.h"
#include "io/yaml.h"

namespace stillpoint::exchange {
namespace {

using testing::Contains;
using testing::HasSubstr;

sim::SimulationConfig sensor() {
  const auto s = io::parse_simulation(
      "rate_hz: 200\n"
      "accelerometer: {bias: [0.1, -0.2, 0.3], matrix: [[1.01, 0.002, 0], [0, 0.99, 0.003], [0.001, 0, 1.02]], "
      "noise_mps2: 0.02, random_walk_mps2_per_sqrts: 0.0004}\n"
      "gyroscope: {bias: [0.01, 0.02, -0.01], matrix: [[1.01, 0.002, 0], [0, 0.99, 0.003], [0.001, 0, 1.02]], "
      "noise_radps: 0.002, random_walk_radps_per_sqrts: 3.0e-5}\n"
      "effects:\n"
      "  - {effect: gyr_temp_lin, k_radps_per_K: [1.0e-4, 2.0e-4, -1.0e-4]}\n"
      "  - {effect: gyr_gsens, G_radps_per_mps2: [[1.0e-4, 2.0e-5, 0], [0, 2.0e-4, 0], [0, 1.0e-5, 3.0e-4]]}\n"
      "  - {effect: gyr_temp_lag, k_radps_per_K: [1.0e-4, 2.0e-4, -1.0e-4], tau_s: 20}\n",
      "sensor.yaml");
  EXPECT_TRUE(s) << (s ? "" : s.error().message);
  return s.value_or(sim::SimulationConfig{});
}

struct Back {
  sim::SimulationConfig simulation;
  std::vector<std::string> lost;
  std::string text;
};

Back there_and_back(ParameterFormat format, const sim::SimulationConfig& s) {
  const WrittenParameters written = write_parameters(format, s);
  const auto read = read_parameters(format, written.text, "file");
  EXPECT_TRUE(read) << (read ? "" : read.error().message) << written.text;
  return {read ? read->simulation : sim::SimulationConfig{}, written.lost, written.text};
}

const sim::EffectConfig* entry(const sim::SimulationConfig& s, const std::string& id) {
  for (const auto& e : s.effects)
    if (e.id == id) return &e;
  return nullptr;
}

TEST(Parameters, SdfKeepsOffsetNoiseAndWalkAndTellsThatMatricesAreLost) {
  const Back b = there_and_back(ParameterFormat::kSdf, sensor());
  EXPECT_DOUBLE_EQ(b.simulation.rate_hz, 200);
  EXPECT_TRUE(b.simulation.gyroscope->bias.isApprox(sensor().gyroscope->bias));
  EXPECT_DOUBLE_EQ(b.simulation.accelerometer->noise_sd, 0.02);
  EXPECT_DOUBLE_EQ(b.simulation.gyroscope->random_walk_per_sqrts, 3e-5);
  EXPECT_THAT(b.lost, Contains(HasSubstr("gyroscope: matrix")));
  EXPECT_THAT(b.lost, Contains("effect gyr_temp_lag"));
}

TEST(Parameters, SdfThatIsNoXmlIsRefusedWithItsName) {
  const auto read = read_parameters(ParameterFormat::kSdf, "<imu><angular", "robot.sdf");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("robot.sdf"));
}

TEST(Parameters, MatlabKeepsTemperatureAndNoiseDensityPerSample) {
  const Back b = there_and_back(ParameterFormat::kMatlab, sensor());
  EXPECT_THAT(b.text, HasSubstr("\"NoiseDensity\""));
  // MATLAB keeps the rate outside: the same density at 100 Hz is a smaller noise a sample.
  EXPECT_NEAR(b.simulation.accelerometer->noise_sd, 0.02 / std::sqrt(2.0), 1e-12);
  ASSERT_NE(entry(b.simulation, "gyr_temp_lin"), nullptr);
  EXPECT_NEAR(entry(b.simulation, "gyr_temp_lin")->parameters.at("k_radps_per_K")[1], 2e-4, 1e-15);
  EXPECT_THAT(b.lost, Contains(HasSubstr("gyr_gsens: its entries off the diagonal")));
  EXPECT_THAT(b.lost, Contains(HasSubstr("gyroscope: scale factors")));
}

TEST(Parameters, MatlabTellsThatARangeIsOfBothSigns) {
  sim::SimulationConfig s = sensor();
  s.effects = {
      {.id = "acc_sat", .parameters = {{"L_mps2", {20, 20, 20}}, {"side", {1, 1, 1}}}, .axes = {}, .window_s = {}}};
  EXPECT_THAT(there_and_back(ParameterFormat::kMatlab, s).lost, Contains(HasSubstr("acc_sat: side")));
  s.effects.front().parameters.erase("side");
  EXPECT_THAT(there_and_back(ParameterFormat::kMatlab, s).lost, testing::Not(Contains(HasSubstr("side"))));
}

TEST(Parameters, KalibrKeepsMatricesAndSensitivityToForce) {
  const Back b = there_and_back(ParameterFormat::kKalibr, sensor());
  EXPECT_TRUE(b.simulation.gyroscope->matrix.isApprox(sensor().gyroscope->matrix, 1e-9)) << b.text;
  EXPECT_NEAR(b.simulation.gyroscope->noise_sd, 0.002, 1e-12);
  ASSERT_NE(entry(b.simulation, "gyr_gsens"), nullptr);
  EXPECT_NEAR(entry(b.simulation, "gyr_gsens")->parameters.at("G_radps_per_mps2")[7], 1e-5, 1e-12);
  EXPECT_THAT(b.lost, Contains(HasSubstr("bias")));
}

TEST(Parameters, Px4PolynomialAboutAnotherTemperatureIsTheSameCurve) {
  const auto read = read_parameters(ParameterFormat::kPx4,
                                    "1\t1\tTC_G0_TREF\t40.0\t9\n1\t1\tTC_G0_X0_0\t0.01\t9\n1\t1\tTC_G0_X1_0\t0.001\t9\n"
                                    "1\t1\tTC_G0_X2_0\t0.0001\t9\n",
                                    "vehicle.params");
  ASSERT_TRUE(read) << read.error().message;
  const auto* quad = entry(read->simulation, "gyr_temp_quad");
  ASSERT_NE(quad, nullptr);
  // At 30 degC: 0.01 + 0.001 (-10) + 0.0001 (100) = 0.01.
  const double at_30 = read->simulation.gyroscope->bias[0] + quad->parameters.at("k1_radps_per_K")[0] * 5 +
                       quad->parameters.at("k2_radps_per_K2")[0] * 25;
  EXPECT_NEAR(at_30, 0.01, 1e-12);
}

TEST(Parameters, Px4KeepsTheOffsetLinearInTemperature) {
  sim::SimulationConfig s = sensor();
  s.gyroscope->matrix.setIdentity();
  const Back b = there_and_back(ParameterFormat::kPx4, s);
  ASSERT_NE(entry(b.simulation, "gyr_temp_lin"), nullptr) << b.text;
  EXPECT_NEAR(entry(b.simulation, "gyr_temp_lin")->parameters.at("k_radps_per_K")[2], -1e-4, 1e-12);
  EXPECT_THAT(b.lost, Contains(HasSubstr("gyroscope: noise")));
}

/// What `stillpoint calibrate --output` writes, with its terms of temperature.
constexpr auto kCalibrated = R"(sensor:
  id: 'board 7'
  accelerometer:  # m/s^2
    bias: [0.1, -0.2, 0.3]
    matrix: [[1.01, 0, 0], [0, 0.99, 0], [0, 0, 1.02]]
  gyroscope:  # rad/s
    bias: [0.01, 0.02, -0.03]
    bias_per_K: [1.0e-4, -2.0e-4, 3.0e-4]
    bias_per_K2: [1.0e-6, 2.0e-6, 0]
    temp_ref_degC: 31
    temp_min_degC: 20
    temp_max_degC: 45
    matrix: [[1.01, 0.002, 0], [0, 0.99, 0.003], [0.001, 0, 1.02]]
)";

TEST(Parameters, ACalibratedSensorsOffsetIsTheSameCurveOfTemperatureThereAndBack) {
  const auto read = read_parameters(ParameterFormat::kSensor, kCalibrated, "board7.yaml");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(read->lost, Contains(HasSubstr("20 to 45 degC")));
  EXPECT_THAT(read->lost, Contains("id"));
  const WrittenParameters written = write_parameters(ParameterFormat::kSensor, read->simulation);
  const auto back = io::parse_yaml(written.text, "written");
  ASSERT_TRUE(back) << written.text;
  const YAML::Node gyr = (*back)["sensor"]["gyroscope"];
  const auto number = [&gyr](const char* key, std::size_t axis) { return gyr[key][axis].as<double>(); };
  constexpr std::array kBias{0.01, 0.02, -0.03}, kPerK{1e-4, -2e-4, 3e-4}, kPerK2{1e-6, 2e-6, 0.0};
  for (const double temp_degC : {20.0, 25.0, 31.0, 45.0})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double t = temp_degC - 31.0, u = temp_degC - gyr["temp_ref_degC"].as<double>();
      EXPECT_NEAR(number("bias", axis) + u * (number("bias_per_K", axis) + u * number("bias_per_K2", axis)),
                  kBias[axis] + t * (kPerK[axis] + t * kPerK2[axis]), 1e-12)
          << temp_degC;
    }
  EXPECT_THAT(written.lost, Contains(HasSubstr("gyroscope: temp_min_degC")));
}

TEST(Parameters, Px4CorrectsAsTheCalibratedSensorDoes) {
  const auto read = read_parameters(ParameterFormat::kSensor, kCalibrated, "board7.yaml");
  ASSERT_TRUE(read);
  const WrittenParameters px4 = write_parameters(ParameterFormat::kPx4, read->simulation);
  EXPECT_THAT(px4.lost, Contains("gyroscope: misalignment"));
  EXPECT_THAT(px4.text, HasSubstr("TC_A0_X0_1\t-0.2\t")) << "raw - X0 is then scaled";
  EXPECT_THAT(px4.text, HasSubstr("TC_A0_SCL_2\t1.02\t"));
}

TEST(Parameters, ImuCalibTakesItsOffsetOffTheScaledReading) {
  const auto read = read_parameters(ParameterFormat::kSensor, kCalibrated, "board7.yaml");
  ASSERT_TRUE(read);
  const Back b = there_and_back(ParameterFormat::kImuCalib, read->simulation);
  EXPECT_THAT(b.text, HasSubstr("SM:\n  - 1.01\n")) << b.text;
  EXPECT_THAT(b.text, HasSubstr("bias:\n  - 0.101\n  - -0.198\n  - 0.306\n")) << "SM reading - bias";
  EXPECT_TRUE(b.simulation.accelerometer->bias.isApprox(Vec3(0.1, -0.2, 0.3), 1e-12));
  EXPECT_THAT(b.lost, Contains("gyroscope"));
}

TEST(Parameters, ASensorThatCannotBeIsRefusedWithItsPlace) {
  for (const auto& [text, what] :
       {std::pair("sensor:\n  gyroscope: {matrix: [[1, 0, 0], [0, 0, 0], [0, 0, 1]]}\n", "no inverse"),
        {"sensor:\n  gyroscope: {bais: [1, 2, 3]}\n", "did you mean 'bias'?"},
        {"rate_hz: 100\n", "no sensor:"}}) {
    const auto read = read_parameters(ParameterFormat::kSensor, text, "board7.yaml");
    ASSERT_FALSE(read) << text;
    EXPECT_THAT(read.error().message, testing::AllOf(HasSubstr("board7.yaml"), HasSubstr(what)));
  }
  const auto read = read_parameters(ParameterFormat::kImuCalib, "SM: [1, 0, 0]\nbias: [0, 0, 0]\n", "calib.yaml");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, testing::AllOf(HasSubstr("calib.yaml"), HasSubstr("SM: 9 numbers")));
}

TEST(Parameters, FormatIsSeenByTheText) {
  for (const auto format : {ParameterFormat::kSdf, ParameterFormat::kKalibr, ParameterFormat::kPx4,
                            ParameterFormat::kSensor, ParameterFormat::kImuCalib})
    EXPECT_EQ(guess_format("file", write_parameters(format, sensor()).text), format);
  EXPECT_EQ(guess_format("imu.json", "{}"), ParameterFormat::kMatlab);
}

}  // namespace
}  // namespace stillpoint::exchange

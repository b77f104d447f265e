#include <cmath>

#include "tests/apps/apps_testing.h"

namespace stillpoint {
namespace {

class DaemonSources : public testing::Test {
 protected:
  /// What the daemon said of this input on standard input; `code` is where it ended.
  std::string daemon(const std::string& source, const std::string& input, int& code) {
    test::write_file(folder_ / "config.yaml",
                     "source: {" + source + "}\ndds: {domain: " + std::to_string(io::own_domain()) + "}\n");
    test::write_file(folder_ / "input", input);
    code = test::run("timeout 60 " STILLPOINTD " --config " + (folder_ / "config.yaml") + " < " + (folder_ / "input"),
                     folder_ / "said");
    return test::read_file(folder_ / "said");
  }
  std::string check(const std::string& config, int& code) {
    test::write_file(folder_ / "check.yaml", config);
    code = test::run(STILLPOINTD " --check-config --config " + (folder_ / "check.yaml"), folder_ / "said");
    return test::read_file(folder_ / "said");
  }
  test::ScratchFolder folder_;
};

std::string lines(const std::string& header, double gyr_unit, double acc_unit) {
  std::ostringstream text;
  text << header;
  for (int k = 0; k < 2000; ++k) {
    const double swing = std::sin(0.01 * k), rate = 0.9 * std::cos(0.01 * k);
    text << 10 * k << ",0," << acc_unit * std::sin(0.9 * swing) << ',' << acc_unit * std::cos(0.9 * swing) << ','
         << gyr_unit * rate << ',' << gyr_unit * 0.01 * (k % 3) << ",0\n";
  }
  return text.str();
}

constexpr const char* kInG = "time_ms,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps\n";
constexpr const char* kInSi = "time_ms,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";

TEST_F(DaemonSources, LinesOnStandardInputAreOneSampleEach) {
  int code = -1;
  const std::string said = daemon("kind: stream, from: stdin", lines(kInG, 57.29578, 1.0), code);
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find("samples=2000 published=2000 refused=0 gaps=0"), std::string::npos) << said;
  EXPECT_EQ(said.find("IMPLAUSIBLE"), std::string::npos) << said;
}

TEST_F(DaemonSources, AMistakenUnitIsNamed) {
  int code = -1;
  EXPECT_NE(daemon("kind: stream, from: stdin", lines(kInSi, 57.29578, 9.8), code).find("likely deg/s given as rad/s"),
            std::string::npos);
  EXPECT_NE(daemon("kind: stream, from: stdin", lines(kInSi, 1.0, 1.0), code).find("likely g given as m/s^2"),
            std::string::npos);
}

TEST_F(DaemonSources, NumbersWithoutNamesAreAskedFor) {
  int code = -1;
  const std::string said = daemon("kind: stream, from: stdin", lines("", 1.0, 9.8), code);
  EXPECT_NE(said.find("name what the columns hold with 'source: columns'"), std::string::npos) << said;
}

TEST_F(DaemonSources, AColumnWhoseNameIsNotKnownIsTold) {
  int code = -1;
  const std::string header = "time_ms,accx_g,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";
  const std::string said = daemon("kind: stream, from: stdin", lines(header.c_str(), 1.0, 9.8), code);
  EXPECT_NE(said.find("passed over, as their names are not known: accx_g (acc_x_g?); ours are such as acc_x_g"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("accelerometer: absent"), std::string::npos) << said;
}

TEST_F(DaemonSources, RowsAtATimeThatIsNoneAreRefusedAndTheUnitNamed) {
  std::ostringstream text;
  text << "time_s,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps\n";
  for (int k = 0; k < 1000; ++k) text << 170'000'000'000 + k << "0000000,0,0,1,0,0,0\n";
  int code = -1;
  const std::string said = daemon("kind: stream, from: stdin", text.str(), code);
  EXPECT_NE(said.find("samples=0 published=0"), std::string::npos) << said;
  EXPECT_NE(said.find("rows are refused: the line's time 'time_s' = 1.7"), std::string::npos) << said;
  EXPECT_NE(said.find("likely in ns: name the column time_ns"), std::string::npos) << said;
}

TEST_F(DaemonSources, AnInertialChipThatDiesIsToldWhileTheMagnetometerSpeaks) {
  std::ostringstream feed;
  feed << "echo time_ms,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps,mag_x_uT,mag_y_uT,mag_z_uT\n"
          "for k in $(seq 100 200); do echo ${k}0,0,0,1.00$((k % 3)),0,0.$((k % 3)),0,20,0.$((k % 3)),-40; done\n"
          "for k in $(seq 201 450); do echo ${k}0,,,,,,,20,0.$((k % 3)),-40; sleep 0.02; done\n";
  test::write_file(folder_ / "feed.sh", feed.str());
  test::write_file(folder_ / "config.yaml",
                   "source: {kind: stream, from: stdin}\ndds: {domain: " + std::to_string(io::own_domain()) + "}\n");
  test::run("sh " + (folder_ / "feed.sh") + " | timeout 60 " STILLPOINTD " --config " + (folder_ / "config.yaml"),
            folder_ / "said");
  const std::string said = test::read_file(folder_ / "said");
  for (const char* line :
       {"STALE: samples come, but no attitude can be made of them",
        "accelerometer: absent, no readings since t = 2.01 s", "gyroscope: absent, no readings since t = 2.01 s"})
    EXPECT_NE(said.find(line), std::string::npos) << line << "\n" << said;
  EXPECT_EQ(said.find("came later than sensor.limits.late_s"), std::string::npos) << said;
}

TEST_F(DaemonSources, ReadingsThatComeTooLateAreCountedAndTold) {
  std::ostringstream text;
  text << "time_ms,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps,mag_x_uT,mag_y_uT,mag_z_uT\n";
  for (int k = 0; k < 1000; ++k) {
    text << 10 * k << ",0,0," << 1.0 + 1e-3 * (k % 3) << ",0," << 0.1 * (k % 3) << ",0,,,\n";
    text << 10 * k - 30 << ",,,,,,," << 20.0 + 0.1 * (k % 3) << ",0,-40\n";
  }
  int code = -1;
  const std::string said = daemon("kind: stream, from: stdin", text.str(), code);
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find("samples=1000 published=1000 refused=1000 "), std::string::npos) << said;
  EXPECT_NE(said.find("readings so far came later than sensor.limits.late_s, 0.01 s"), std::string::npos) << said;
}

TEST_F(DaemonSources, StampsThatAreCoarserThanTheRowsAreTold) {
  std::ostringstream text;
  text << kInG;
  for (int k = 0; k < 1000; ++k) text << k / 10 * 100 << ",0,0," << 1.0 + 1e-3 * (k % 3) << ",0,0,0\n";
  int code = -1;
  const std::string said = daemon("kind: stream, from: stdin", text.str(), code);
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find("samples=1000 published=100 refused=900 "), std::string::npos) << said;
  EXPECT_NE(said.find("90 % of the rows are refused, as their stamps do not advance"), std::string::npos) << said;
}

TEST_F(DaemonSources, TheConfigurationIsCheckedAgainstWhatIsThere) {
  int code = 0;
  const auto expect_refusal = [&](const std::string& config, const char* why) {
    EXPECT_NE(check(config, code).find(why), std::string::npos) << test::read_file(folder_ / "said");
    EXPECT_EQ(code, 78) << config;
  };
  expect_refusal("sensor: {id: a}\n", "no 'source:'");
  expect_refusal("source: {kind: recording, file: gone.csv}\n", "check.yaml:1:33: ");
  expect_refusal("source: {kind: recording, file: /tmp}\n", "/tmp: is a folder");
  expect_refusal("source: {kind: stream, from: /tmp}\n", "/tmp: is a folder");
  expect_refusal("source: {kind: stream, from: 'udp://:0'}\n", "names no port");
  test::write_file(folder_ / "still.yaml", "rate_hz: 100\naccelerometer: {noise_mps2: 0.02}\n");
  expect_refusal("source: {kind: simulation, file: still.yaml}\n", "no 'motion:' block");
  check("source: {kind: stream, from: /dev/ttyNotYet}\n", code);
  EXPECT_EQ(code, 0) << "a device may come later";
}

}  // namespace
}  // namespace stillpoint

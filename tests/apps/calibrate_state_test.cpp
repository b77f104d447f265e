/// `stillpoint calibrate --recording --state`: nothing that was learnt is lost, and nothing that is damaged is used.
#include <gmock/gmock.h>

#include <random>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Forty seconds of rest in one attitude; from `stuck_from_s` on the same reading again and again.
std::string recording(const std::string& header, double stuck_from_s = 1e9, double unit_mps2 = 1.0) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  std::ostringstream text;
  text << header << "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";
  std::string reading;
  for (int k = 0; k < 2000; ++k) {
    if (0.02 * k < stuck_from_s) {
      std::ostringstream row;
      for (const double mean : {0.3, -0.2, 9.7}) row << ',' << (mean + 0.02 * normal(random)) * unit_mps2;
      for (int axis = 0; axis < 3; ++axis) row << ',' << 0.004 + 0.001 * normal(random);
      reading = row.str();
    }
    text << 0.02 * k << reading << '\n';
  }
  return text.str();
}

struct StateAnswer {
  int exit_code = -1;
  std::string json, told;
};
class CalibrateState : public ::testing::Test {
 protected:
  StateAnswer calibrate(const std::string& table, const std::string& state) {
    write_file(folder_ / "recording.csv", table);
    fs::remove(folder_ / "out.json");
    const std::string command = std::string(STILLPOINT) + " calibrate --recording " + (folder_ / "recording.csv") +
                                " --json " + (folder_ / "out.json") + (state.empty() ? "" : " --state " + state);
    StateAnswer a;
    a.exit_code = run(command, folder_ / "err");
    a.json = read_file(folder_ / "out.json");
    a.told = read_file(folder_ / "err");
    return a;
  }
  ScratchFolder folder_;
};

TEST_F(CalibrateState, WhatWasLearntServesTheNextRun) {
  const std::string state = folder_ / "any.name";
  EXPECT_THAT(calibrate(recording(""), state).json, HasSubstr("\"windows\": 19,"));
  const StateAnswer second = calibrate(recording(""), state);
  EXPECT_EQ(second.exit_code, 0) << second.told;
  EXPECT_THAT(second.json, HasSubstr("\"windows\": 38,"));  // of the accelerometer: both runs
}

TEST_F(CalibrateState, ADamagedOneIsNamedAndLeftAlone) {
  const std::string state = folder_ / "imu.state";
  ASSERT_EQ(calibrate(recording(""), state).exit_code, 0);
  const std::string whole = read_file(state);
  std::string flipped = whole, newer = whole;
  flipped[whole.size() / 2] ^= 0x10;
  newer[std::string("stillpoint-state ").size()] = '9';
  for (const std::string& damaged : {std::string(), whole.substr(0, 20), whole.substr(0, whole.size() - 1), flipped,
                                     newer, std::string(5000, '\xff')}) {
    write_file(state, damaged);
    const StateAnswer a = calibrate(recording(""), state);
    EXPECT_EQ(a.exit_code, 65);
    EXPECT_THAT(a.told, HasSubstr("set it aside"));
    EXPECT_EQ(read_file(state), damaged);
  }
  EXPECT_EQ(calibrate(recording(""), folder_ / ".").exit_code, 65);  // a folder
}

TEST_F(CalibrateState, OfAnotherSensorIsRefused) {
  const std::string state = folder_ / "imu.state";
  ASSERT_EQ(calibrate(recording("# sensor: first\n"), state).exit_code, 0);
  EXPECT_EQ(calibrate(recording("# sensor: first\n"), state).exit_code, 0);
  const StateAnswer other = calibrate(recording("# sensor: second\n"), state);
  EXPECT_EQ(other.exit_code, 65);
  EXPECT_THAT(other.told, HasSubstr("'first', the recording of 'second'"));
  EXPECT_EQ(calibrate(recording(""), state).exit_code, 0);  // a recording that names none
}

TEST_F(CalibrateState, WhatCannotBeKeptIsShownAllTheSame) {
  const StateAnswer a = calibrate(recording(""), folder_ / "no/such/folder/imu.state");
  EXPECT_EQ(a.exit_code, 73);
  EXPECT_THAT(a.told, HasSubstr("cannot be written"));
  EXPECT_THAT(a.json, HasSubstr("\"accelerometer\""));
}

TEST_F(CalibrateState, GivesASensorThatTheDaemonTakes) {
  write_file(folder_ / "recording.csv", recording(""));
  const std::string yaml = folder_ / "sensor.yaml", given = std::string(STILLPOINT) + " calibrate --recording " +
                                                            (folder_ / "recording.csv") + " --output " + yaml;
  ASSERT_EQ(run(given + " --sensor-id bench-7 --gravity 9.81 --json " + (folder_ / "out.json"), folder_ / "err"), 0);
  EXPECT_THAT(read_file(folder_ / "out.json"), HasSubstr("\"stated\": true"));
  EXPECT_THAT(read_file(yaml), HasSubstr("id: 'bench-7'"));
  write_file(yaml, read_file(yaml) + "source: {kind: stream, from: stdin}\n");
  EXPECT_EQ(run(std::string(STILLPOINTD) + " --check-config --config " + yaml, folder_ / "err"), 0)
      << read_file(folder_ / "err");
  EXPECT_EQ(run(given + " --gravity 3.7", folder_ / "err"), 64);
}

TEST_F(CalibrateState, SaysOfEachQuantityWhatIsMissing) {
  const std::string json = calibrate(recording(""), "").json;
  for (const char* said : {"accelerometer: lay it down with x up", "gyroscope: a second attitude",
                           "gyroscope: scale of x is known to", "gravity is taken for 9.80665"})
    EXPECT_THAT(json, HasSubstr(said));
}

TEST_F(CalibrateState, AFaultAndAWrongUnitAreNamed) {
  const StateAnswer stuck = calibrate(recording("", 20.0), "");
  EXPECT_THAT(stuck.json, HasSubstr("\"sensor\": \"accelerometer\",\n      \"status\": \"stuck\""));
  EXPECT_THAT(calibrate(recording("", 1e9, 1.0 / 9.8), "").json, HasSubstr("is the unit in the column's name"));
}

}  // namespace
}  // namespace stillpoint::test

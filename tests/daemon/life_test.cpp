/// The daemon's life as an operator sees it: exit codes, signals, what is kept, what is said.
#include <thread>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

using ::testing::Test;

std::string simulated(const ScratchFolder& scratch, const std::string& speed) {
  return "source: {kind: simulation, file: " + configs("sim_handheld.yaml") + ", speed: " + speed +
         "}\nsensor: {id: test}\nstate: {directory: " + (scratch / "state") +
         ", save_period_s: 0.1}\ndds: {domain: " + std::to_string(io::own_domain()) +
         ", ros2: false, raw_topic: \"\"}\n";
}

std::string start_line(const ScratchFolder& scratch, const std::string& log) {
  return "exec " STILLPOINTD " --config " + (scratch / "d.yaml") + " 2>" + (scratch / log);
}

bool wait_for_text(const std::string& file, const std::string& text) {
  for (int i = 0; i < 400; ++i) {
    if (read_file(file).find(text) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

TEST(Daemon, EndsCleanlyWhenAskedAndStartsAgainWithWhatItLearnt) {
  const ScratchFolder scratch;
  write_file(scratch / "d.yaml", simulated(scratch, "20"));
  Process daemon({"/bin/sh", "-c", start_line(scratch, "1.log")});
  ASSERT_TRUE(wait_for_text(scratch / "1.log", "calibration version=3")) << read_file(scratch / "1.log");
  daemon.send(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
  EXPECT_NE(read_file(scratch / "1.log").find("ended: samples="), std::string::npos);

  Process again({"/bin/sh", "-c", start_line(scratch, "2.log")});
  ASSERT_TRUE(wait_for_text(scratch / "2.log", "state/test.state")) << read_file(scratch / "2.log");
  again.send(SIGINT);
  EXPECT_EQ(again.wait(), 0);
}

TEST(Daemon, KilledWithoutWarningLeavesAWholeStateFile) {
  const ScratchFolder scratch;
  write_file(scratch / "d.yaml", simulated(scratch, "50"));
  for (int round = 0; round < 3; ++round) {
    const std::string log = std::to_string(round) + ".log";
    Process daemon({"/bin/sh", "-c", start_line(scratch, log)});
    ASSERT_TRUE(wait_for_text(scratch / log, "calibration version="));
    for (int i = 0; i < 60 && !std::filesystem::exists(scratch / "state/test.state"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    std::this_thread::sleep_for(std::chrono::milliseconds(37 * round));
    daemon.send(SIGKILL);
    daemon.wait();
    ASSERT_EQ(read_file(scratch / log).find("set aside"), std::string::npos) << read_file(scratch / log);
    if (round > 0) {
      EXPECT_NE(read_file(scratch / log).find("state/test.state"), std::string::npos);
    }
  }
}

TEST(Daemon, SaysWhatIsWrongWithTheConfigurationAndExitsWith78) {
  const ScratchFolder scratch;
  write_file(scratch / "d.yaml", "source: {kind: recording, file: x.csv, sped: 2}\nrest: {window_s: -1}\n");
  EXPECT_EQ(run(STILLPOINTD " --config " + (scratch / "d.yaml"), scratch / "log"), 78);
  const std::string log = read_file(scratch / "log");
  EXPECT_NE(log.find("d.yaml:1:40: unknown key 'sped'; did you mean 'speed'?"), std::string::npos) << log;
  EXPECT_NE(log.find("d.yaml:2:18: 'window_s'"), std::string::npos) << log;
}

TEST(Daemon, WithoutItsSourceStopsWith66OrWaitsAsConfigured) {
  const ScratchFolder scratch;
  write_file(scratch / "d.yaml", "source: {kind: recording, file: none.csv}\n");
  EXPECT_EQ(run(STILLPOINTD " --config " + (scratch / "d.yaml"), scratch / "log"), 66);
  EXPECT_NE(read_file(scratch / "log").find("none.csv"), std::string::npos);

  write_file(scratch / "d.yaml", "source: {kind: recording, file: none.csv, wait_for_file: true}\n");
  Process waiting({"/bin/sh", "-c", start_line(scratch, "2.log")});
  EXPECT_TRUE(wait_for_text(scratch / "2.log", "waiting for"));
  waiting.send(SIGTERM);
  EXPECT_EQ(waiting.wait(), 0);
}

TEST(Daemon, AfterTheEndOfItsSourceReportsStaleAndWaitsWhereToldTo) {
  const ScratchFolder scratch;
  write_file(scratch / "r.csv", "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2\n0,0,0,9.8\n0.01,0,0,9.8\n0.02,0,0,9.8\n");
  write_file(scratch / "d.yaml", "source: {kind: recording, file: r.csv, at_end: wait}\ndds: {domain: " +
                                     std::to_string(io::own_domain()) + "}\n");
  Process daemon({"/bin/sh", "-c", start_line(scratch, "log")});
  EXPECT_TRUE(wait_for_text(scratch / "log", "STALE: the source has ended")) << read_file(scratch / "log");
  daemon.send(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
}

}  // namespace
}  // namespace stillpoint::test

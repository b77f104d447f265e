/// What the world does to a daemon: a full disk, a log that nobody reads, too few rights, one core, a twin. Each time
/// it says what is wrong and keeps what it had.
#include "tests/daemon/daemon_fixture.h"

namespace stillpoint::test {
namespace {

TEST_F(DaemonFaults, AFullDiskIsToldOnceAndWhatWasKeptBeforeStays) {
  configure();
  auto first = start();
  ASSERT_TRUE(keeps_a_state()) << log();
  EXPECT_EQ(end(*first), 0);
  // Files that may not grow beyond 12 blocks of 512 bytes: room for a short log, not for a state.
  auto full = start("ulimit -f 12;", "full");
  EXPECT_TRUE(says("cannot be written whole", "full")) << log("full");
  EXPECT_TRUE(says("calibration version", "full"));
  EXPECT_EQ(end(*full), 0) << log("full");
  const std::string said = log("full");
  const auto told = said.find("cannot be written whole");
  EXPECT_EQ(said.find("cannot be written whole", told + 1), std::string::npos) << said;
  auto again = start("", "again");
  EXPECT_TRUE(says("state/test.state", "again")) << log("again");
  EXPECT_EQ(log("again").find("set aside"), std::string::npos) << log("again");
  EXPECT_EQ(end(*again), 0);
}

TEST_F(DaemonFaults, ALogThatTakesNothingDoesNotEndIt) {
  configure();
  auto daemon = start("", "/dev/full");
  EXPECT_TRUE(keeps_a_state());
  EXPECT_EQ(end(*daemon), 0);
}

TEST_F(DaemonFaults, ADamagedStateIsSetAsideAndTheVersionBeforeServes) {
  configure();
  auto daemon = start();
  ASSERT_TRUE(within_20_s([this] { return fs::exists(scratch_ / "state/test.1.state"); })) << log();
  EXPECT_EQ(end(*daemon), 0);
  fs::resize_file(scratch_ / "state/test.state", fs::file_size(scratch_ / "state/test.state") / 2);
  auto again = start("", "again");
  EXPECT_TRUE(says("test.state: damaged: length or checksum is wrong; set aside as", "again")) << log("again");
  EXPECT_TRUE(says("state/test.1.state", "again")) << log("again");
  EXPECT_EQ(end(*again), 0);
  EXPECT_TRUE(fs::exists(scratch_ / "state/test.state.damaged"));
}

TEST_F(DaemonFaults, ATwinOfTheSameSensorIsRefusedAndOneOfAnotherIsTold) {
  configure("", "1");
  auto first = start();
  ASSERT_TRUE(says("sensor test, source")) << log();
  auto twin = start("", "twin");
  EXPECT_EQ(twin->wait(), 73);
  EXPECT_NE(log("twin").find("another stillpointd keeps the calibration of sensor 'test'"), std::string::npos)
      << log("twin");
  std::string other = read_file(scratch_ / "d.yaml");
  other.replace(other.find("id: test"), 8, "id: other");
  write_file(scratch_ / "d.yaml", other);
  auto second = start("", "second");
  EXPECT_TRUE(says("publish 'stillpoint/attitude' in domain", "second")) << log("second");
  EXPECT_TRUE(says("publish 'stillpoint/attitude' in domain")) << log();
  EXPECT_EQ(end(*second), 0);
  EXPECT_EQ(end(*first), 0);
}

TEST_F(DaemonFaults, OneCoreIsEnough) {
  configure();
  wrapper_ = "taskset -c 0";
  auto daemon = start();
  EXPECT_TRUE(keeps_a_state()) << log();
  EXPECT_EQ(end(*daemon), 0);
  EXPECT_NE(log().find("refused=0"), std::string::npos) << log();
  EXPECT_EQ(log().find("other program"), std::string::npos) << log();
}

TEST_F(DaemonFaults, WithoutTheRightsItSaysWhatIsRefusedAndRunsOn) {
  if (geteuid() != 0) GTEST_SKIP() << "LOUD: SKIPPED: only root can give its rights away";
  configure("threads: {sensor_core: 1023, fifo_priority: 50, lock_memory: true, cpu_latency_us: 0}\n");
  fs::create_directory(scratch_ / "state");
  fs::permissions(scratch_ / "", fs::perms::all);
  fs::permissions(scratch_ / "state", fs::perms::all);
  wrapper_ = "setpriv --reuid=65534 --regid=65534 --clear-groups";
  if (run(wrapper_ + " test -r " + configs("sim_handheld.yaml"), scratch_ / "rights") != 0)
    GTEST_SKIP() << "LOUD: SKIPPED: the project's folder is not open to other users";
  auto daemon = start("ulimit -l 64;");
  EXPECT_TRUE(keeps_a_state()) << log();
  EXPECT_EQ(end(*daemon), 0);
  EXPECT_NE(log().find("normal scheduling instead of SCHED_FIFO 50"), std::string::npos) << log();
#ifndef __SANITIZE_ADDRESS__  // which lets mlockall succeed without doing anything
  EXPECT_NE(log().find("memory stays unlocked"), std::string::npos) << log();
#endif
  EXPECT_NE(log().find("not pinned to core 1023"), std::string::npos) << log();
  EXPECT_NE(log().find("processors sleep as the system decides: /dev/cpu_dma_latency"), std::string::npos) << log();

  fs::permissions(scratch_ / "state", fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_exec);
  auto refused = start("", "refused");
  EXPECT_TRUE(says("what is learnt is not kept", "refused")) << log("refused");
  EXPECT_TRUE(says("calibration version=", "refused")) << "it runs all the same: " << log("refused");
  EXPECT_NE(log("refused").find("Permission denied"), std::string::npos) << log("refused");
  EXPECT_EQ(end(*refused), 0);
}

TEST_F(DaemonFaults, AStateFolderThatCannotBeMadeYetIsTriedAgainAndTheStateKeptThen) {
  configure();
  write_file(scratch_ / "state", "a file where the folder should be");
  auto daemon = start();
  EXPECT_TRUE(says("what is learnt is not kept: ")) << log();
  EXPECT_TRUE(says("calibration version=2")) << log();
  fs::remove(scratch_ / "state");
  EXPECT_TRUE(keeps_a_state()) << log();
  EXPECT_TRUE(says("state: well again")) << log();
  EXPECT_EQ(end(*daemon), 0);
}

TEST_F(DaemonFaults, TheLatencyAskedOfTheProcessorsIsHeldWhileItRuns) {
  const std::string device = "/dev/cpu_dma_latency";
  if (access(device.c_str(), W_OK) != 0)
    GTEST_SKIP() << "LOUD: SKIPPED: " << device << " is not there or not ours to write";
  configure("threads: {cpu_latency_us: 1000000}\n");  // so long that nothing changes for the others
  auto daemon = start();
  EXPECT_TRUE(keeps_a_state()) << log();
  bool held = false;
  for (const auto& file : fs::directory_iterator("/proc/" + std::to_string(daemon->id()) + "/fd"))
    held = held || fs::read_symlink(file) == device;
  EXPECT_TRUE(held) << log();
  EXPECT_EQ(end(*daemon), 0);
}

TEST_F(DaemonFaults, AFolderOrADeviceInPlaceOfARecordingIsSaidToBeNone) {
  for (const std::string path : {"/tmp", "/dev/zero"}) {
    write_file(scratch_ / "d.yaml", "source: {kind: recording, file: " + path + "}\n");
    EXPECT_EQ(run(STILLPOINTD " --config " + (scratch_ / "d.yaml"), scratch_ / "log"), 66) << path;
    EXPECT_NE(log().find("neither a file nor a pipe"), std::string::npos) << log();
  }
}

TEST_F(DaemonFaults, ARecordingComesThroughAPipeAndMayVanishWhileItIsReplayed) {
  std::string rows = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps\n";
  for (const std::string time : {"0", "0.01", "0.02", "1.5"}) rows += time + ",0,0,9.8,0,0,0\n";
  write_file(scratch_ / "r.csv", rows);
  write_file(scratch_ / "d.yaml",
             "source: {kind: recording, file: pipe}\ndds: {domain: " + std::to_string(io::own_domain()) + "}\n");
  auto daemon = start("cd " + (scratch_ / "") + "; mkfifo pipe; cat r.csv > pipe &");
  EXPECT_TRUE(says("source ")) << log();
  fs::remove(scratch_ / "r.csv");
  fs::remove(scratch_ / "pipe");
  EXPECT_EQ(daemon->wait(), 0) << log();
  EXPECT_NE(log().find("samples=4 published=4"), std::string::npos) << log();
}

}  // namespace
}  // namespace stillpoint::test

/// The whole daemon, all topics on, while a subscriber comes and goes: what the preset `tsan` runs to find a race
/// anywhere in it. In other builds the same run shows that the daemon ends cleanly.
#include <filesystem>
#include <thread>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

class DaemonThreads : public testing::TestWithParam<const char*> {};

TEST_P(DaemonThreads, RunWithoutARaceWhileSubscribersComeAndGo) {
  const std::string transport = GetParam();
  const std::string domain = std::to_string(io::own_domain());
  const ScratchFolder scratch;
  write_file(scratch / "d.yaml", "source: {kind: simulation, file: " + configs("sim_handheld.yaml") +
                                     ", speed: 10}\nsensor: {id: test}\nstate: {directory: " + (scratch / "state") +
                                     ", save_period_s: 0.1}\ndds: {domain: " + domain + ", transport: " + transport +
                                     "}\n");
  Process daemon({STILLPOINTD, "--config", scratch / "d.yaml"}, scratch / "log");
  for (int round = 0; round < 2; ++round) {
    Process subscriber({DDS_PEER, "subscribe", domain, transport, "30"});
    for (std::string said = "0"; said.find_first_of("123456789") == std::string::npos;) {
      said = subscriber.some_output();
      ASSERT_FALSE(said.empty()) << "the subscriber ended:\n" << read_file(scratch / "log");
    }
    std::this_thread::sleep_for(std::chrono::seconds(1));
    // Killed inside Fast DDS's own lock of the shared memory it would stop the daemon's writes until its lease ends.
    subscriber.send(SIGTERM);
    subscriber.wait();  // its exit code tells of Fast DDS's own locks, which ThreadSanitizer does not know
  }
  daemon.send(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
  const std::string log = read_file(scratch / "log");
  EXPECT_NE(log.find("ended: samples="), std::string::npos) << log;
  EXPECT_EQ(log.find("ThreadSanitizer"), std::string::npos) << log;
}

INSTANTIATE_TEST_SUITE_P(Transports, DaemonThreads, testing::Values("udp", "shm", "data_sharing"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace stillpoint::test

/// What must never be waited for: a log, a disk, the network, the process of DDS. The attitude goes on meanwhile.
#include <fcntl.h>

#include <array>
#include <atomic>

#include "core/units.h"
#include "io/dds_subscriber.h"
#include "tests/daemon/daemon_fixture.h"
#include "tests/dds/network_namespace.h"

namespace stillpoint::test {
namespace {

using DaemonWaits = DaemonFaults;

/// Its reader holds the pipe open, full, and never reads.
TEST_F(DaemonWaits, APipeThatNobodyReadsCostsLinesAndNeitherSamplesNorTheEnd) {
  configure("", "1");
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe2(ends.data(), O_NONBLOCK), 0);
  const std::string block(4096, 'x');
  while (write(ends[1], block.data(), block.size()) > 0) continue;
  fcntl(ends[1], F_SETFL, 0);
  const auto file = "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(ends[1]);
  auto daemon = start("", file);
  std::atomic<int> received{0};
  io::DdsParams params;
  params.domain = io::own_domain();
  const auto subscriber =
      io::DdsSubscriber::create(params, {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  EXPECT_TRUE(within_20_s([&] { return received > 300; })) << received;
  const auto asked = std::chrono::steady_clock::now();
  EXPECT_EQ(end(*daemon), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(4));
  close(ends[0]);
  close(ends[1]);
}

TEST_F(DaemonWaits, ADiskThatTakesSecondsToSyncCostsNoAttitude) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "LOUD: SKIPPED: the sanitizer wants to be the first library";
#endif
  configure("", "5");
  auto daemon = start("LD_PRELOAD=" SLOW_DISK " ");
  std::atomic<std::int64_t> last_ns{0}, longest_ns{0};
  io::DdsParams params;
  params.domain = io::own_domain();
  const auto subscriber =
      io::DdsSubscriber::create(params, {.attitude = [&](const AttitudeMessage&, std::int64_t t_ns) {
                                  if (last_ns != 0 && t_ns - last_ns > longest_ns) longest_ns = t_ns - last_ns;
                                  last_ns = t_ns;
                                }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  EXPECT_TRUE(keeps_a_state()) << log();
  EXPECT_TRUE(says("calibration version=4")) << log();
  EXPECT_EQ(end(*daemon), 0);
  EXPECT_LT(in_seconds(longest_ns.load()), 1.0) << log();
}

TEST_F(DaemonWaits, AnAddressThatIsNotThereYetIsWaitedForAndServedWhenItComes) {
  const NetworkNamespace network;
  if (!network.ready())
    GTEST_SKIP() << "LOUD: SKIPPED: no network namespace of one's own here (root and `ip` are needed)";
  configure("", "1");
  std::string text = read_file(scratch_ / "d.yaml");
  text.replace(text.find("ros2: false"), 11, "ros2: false, interface: 10.77.0.2");
  write_file(scratch_ / "d.yaml", text);
  auto daemon = start();
  EXPECT_TRUE(says("nothing is published yet: dds: no interface of this machine is up with the address 10.77.0.2"))
      << log();
  ASSERT_EQ(std::system("ip addr add 10.77.0.2/24 dev other"), 0);
  EXPECT_TRUE(says("dds: well again")) << log();
  EXPECT_EQ(run(STILLPOINT " status --domain " + std::to_string(io::own_domain()) +
                    " --interface 10.77.0.2 --timeout 5 >" + (scratch_ / "status"),
                scratch_ / "status-log"),
            0)
      << read_file(scratch_ / "status-log");
  EXPECT_EQ(end(*daemon), 0);
}

TEST_F(DaemonWaits, ADdsProcessThatIsKilledCostsSomeAttitudesAndTheSensorThreadNothing) {
  configure("", "1");
  std::string text = read_file(scratch_ / "d.yaml");
  text.replace(text.find("ros2: false"), 11, "ros2: false, own_process: true");
  write_file(scratch_ / "d.yaml", text);
  auto daemon = start();
  ASSERT_TRUE(says("sensor test, source")) << log();
  std::atomic<std::uint64_t> received{0}, last{0}, longest_jump{0};
  io::DdsParams params;
  params.domain = io::own_domain();
  const auto subscriber = io::DdsSubscriber::create(params, {.attitude = [&](const AttitudeMessage& m, std::int64_t) {
                                                      if (last != 0 && m.sequence - last > longest_jump)
                                                        longest_jump = m.sequence - last;
                                                      last = m.sequence;
                                                      ++received;
                                                    }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  ASSERT_TRUE(within_20_s([&] { return received > 50; })) << log();
  const std::string own = std::to_string(daemon->id());
  const pid_t child = std::atoi(read_file("/proc/" + own + "/task/" + own + "/children").c_str());
  ASSERT_GT(child, 0);
  kill(child, SIGKILL);  // no sanitizer can turn it into an exit of its own
  const std::uint64_t before = received;
  EXPECT_TRUE(within_20_s([&] { return received > before + 100; })) << log();
  EXPECT_LT(longest_jump, 100U) << "a second, at 100 Hz";
  EXPECT_NE(log().find("the process of DDS was ended by Killed; it is started anew"), std::string::npos) << log();
  EXPECT_EQ(end(*daemon), 0);
  EXPECT_NE(log().find(" gaps=0 "), std::string::npos) << log();
}

TEST_F(DaemonWaits, TooFewFilesForDdsIsOneLineAndTheAttitudeRunsOn) {
  configure("", "1");
  auto daemon = start("ulimit -n 12;", "limited");
  EXPECT_TRUE(says("nothing is published yet: dds: ", "limited")) << log("limited");
  EXPECT_TRUE(says("calibration version=1", "limited")) << log("limited");
  EXPECT_EQ(end(*daemon), 0) << log("limited");
}

}  // namespace
}  // namespace stillpoint::test

/// The daemon as systemd sees it: ready, alive by the progress of its sensor thread, reloading, stopping. The test
/// plays the service manager.
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "io/dds_subscriber.h"
#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

class DaemonService : public testing::Test {
 protected:
  void SetUp() override {
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = scratch_ / "notify";
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const timeval limit{0, 100'000};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    configure("");
    daemon_ = std::make_unique<Process>(
        std::vector<std::string>{"/usr/bin/env", "NOTIFY_SOCKET=" + path, "WATCHDOG_USEC=400000", STILLPOINTD,
                                 "--config", scratch_ / "d.yaml"},
        scratch_ / "log");
  }
  void TearDown() override { close(socket_); }

  void configure(const std::string& extra) {
    write_file(scratch_ / "d.yaml",
               "source: {kind: simulation, file: " + configs("sim_handheld.yaml") + "}\nsensor: {id: test}\n" +
                   "dds: {domain: " + std::to_string(io::own_domain()) + ", ros2: false, raw_topic: \"\"}\n" + extra);
  }
  /// All messages until one holds the text, at most ten seconds of them; empty: it did not come.
  std::string until(const std::string& text) {
    for (const auto end = Clock::now() + std::chrono::seconds(10); Clock::now() < end;)
      if (const std::string one = next(); one.find(text) != std::string::npos) return one;
    return {};
  }
  std::string next() {
    std::string message(4096, '\0');
    const ssize_t n = recv(socket_, message.data(), message.size(), 0);
    message.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return message;
  }
  int fed_within(std::chrono::milliseconds time) {
    int fed = 0;
    for (const auto end = Clock::now() + time; Clock::now() < end;) fed += next() == "WATCHDOG=1" ? 1 : 0;
    return fed;
  }
  [[nodiscard]] std::string log() const { return read_file(scratch_ / "log"); }
  /// The log has a thread of its own: a line may come after what it tells of.
  [[nodiscard]] bool says(const std::string& text) const {
    for (int i = 0; i < 200; ++i) {
      if (log().find(text) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  [[nodiscard]] pid_t thread_named(const std::string& name) const {
    for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(daemon_->id()) + "/task"))
      if (read_file(task.path() / "comm") == name + "\n") return std::stoi(task.path().filename());
    return 0;
  }

  ScratchFolder scratch_;
  int socket_ = -1;
  std::unique_ptr<Process> daemon_;
};

TEST_F(DaemonService, IsReadySaysWhatItDoesAndEndsWhenAsked) {
  EXPECT_EQ(until("READY=1"), "READY=1") << log();
  EXPECT_NE(until("STATUS="), "") << log();
  daemon_->send(SIGTERM);
  EXPECT_EQ(until("STOPPING=1"), "STOPPING=1") << log();
  EXPECT_EQ(daemon_->wait(), 0);
}

TEST_F(DaemonService, FeedsTheWatchdogAsLongAsTheSensorThreadGoesOnAndNoLonger) {
  ASSERT_EQ(until("READY=1"), "READY=1") << log();
  EXPECT_GE(fed_within(std::chrono::seconds(1)), 4);
  const pid_t sensor = thread_named("sensor");
  ASSERT_GT(sensor, 0);
  if (ptrace(PTRACE_SEIZE, sensor, nullptr, nullptr) != 0)
    GTEST_SKIP() << "LOUD: SKIPPED: no thread may be stopped here";
  ASSERT_EQ(ptrace(PTRACE_INTERRUPT, sensor, nullptr, nullptr), 0);
  waitpid(sensor, nullptr, __WALL);
  fed_within(std::chrono::milliseconds(300));
  EXPECT_EQ(fed_within(std::chrono::seconds(1)), 0) << "all other threads run on";
  ptrace(PTRACE_DETACH, sensor, nullptr, nullptr);
  EXPECT_GE(fed_within(std::chrono::seconds(1)), 4);
}

TEST_F(DaemonService, OnSighupReadsWhatCanChangeNowAndNamesWhatCannot) {
  ASSERT_EQ(until("READY=1"), "READY=1") << log();
  configure("stale_after_s: 3\nrest: {window_s: 1.5}\n");
  daemon_->send(SIGHUP);
  EXPECT_NE(until("RELOADING=1"), "") << log();
  EXPECT_EQ(until("READY=1"), "READY=1") << log();
  EXPECT_TRUE(says("read again: stale_after_s\n")) << log();
  EXPECT_TRUE(says("only at the next start: rest.window_s\n")) << log();

  write_file(scratch_ / "d.yaml", "stale_after_s: -3\n");
  daemon_->send(SIGHUP);
  EXPECT_NE(until("RELOADING=1"), "") << log();
  EXPECT_EQ(until("READY=1"), "READY=1") << log();
  EXPECT_TRUE(says("the configuration stays as it was:\n")) << log();
  daemon_->send(SIGTERM);
  EXPECT_EQ(daemon_->wait(), 0) << log();
}

TEST_F(DaemonService, OnSighupPublishesElsewhereWithoutAPause) {
  ASSERT_EQ(until("READY=1"), "READY=1") << log();
  configure("");
  std::string text = read_file(scratch_ / "d.yaml");
  text.replace(text.find("ros2: false"), 11, "ros2: false, attitude_topic: elsewhere");
  write_file(scratch_ / "d.yaml", text);
  daemon_->send(SIGHUP);
  EXPECT_NE(until("RELOADING=1"), "") << log();
  std::atomic<int> received{0};
  io::DdsParams params;
  params.domain = io::own_domain();
  params.attitude_topic = "elsewhere";
  const auto subscriber =
      io::DdsSubscriber::create(params, {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  for (int i = 0; i < 200 && received < 20; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_GE(received, 20) << log();
  daemon_->send(SIGTERM);
  EXPECT_EQ(daemon_->wait(), 0);
  EXPECT_NE(log().find(" gaps=0 "), std::string::npos) << log();
}

}  // namespace
}  // namespace stillpoint::test

/// The programs themselves in front of payloads that cannot be deserialised: watch, record and a daemon that takes its
/// readings from ROS 2 go on.
#include "tests/dds/malformed.h"

#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/daemon/daemon_fixture.h"
#include "tests/dds/dds_testing.h"

namespace stillpoint::test {
namespace {

class MalformedPayloads : public DaemonFaults {
 protected:
  [[nodiscard]] std::unique_ptr<Process> tool(const std::string& arguments, const std::string& output) const {
    return std::make_unique<Process>(
        std::vector<std::string>{"/bin/sh", "-c",
                                 "exec " STILLPOINT " " + arguments + " --domain " + std::to_string(params_.domain) +
                                     " >" + (scratch_ / output) + " 2>" + (scratch_ / "tool_log")});
  }
  io::DdsParams params_ = test_params();
};

TEST_F(MalformedPayloads, NeitherWatchNorRecordEndsAndBothTakeTheGoodMessagesAfterThem) {
  MalformedPublisher stranger(params_);
  const auto watch = tool("watch --json", "watched");
  const auto record = tool("record --output " + (scratch_ / "out.csv") + " --timeout 60", "recorded");
  const auto publisher = io::DdsPublisher::create(params_);
  ASSERT_TRUE(publisher) << publisher.error().message;
  std::uint64_t k = 0;
  const auto both_have_more_than = [&](std::size_t watched, std::size_t rows) {
    return within_20_s([&] {
      (*publisher)->publish(attitude_message(++k));
      (*publisher)->publish_raw(raw_sample(k), 0);
      return read_file(scratch_ / "watched").size() > watched && read_file(scratch_ / "out.csv").size() > rows;
    });
  };
  ASSERT_TRUE(both_have_more_than(0, 0)) << log("tool_log");
  stranger.write_all();
  const std::size_t watched = read_file(scratch_ / "watched").size(), rows = read_file(scratch_ / "out.csv").size();
  EXPECT_TRUE(both_have_more_than(watched, rows)) << log("tool_log");
  EXPECT_EQ(end(*watch), 0) << log("tool_log");
  EXPECT_EQ(end(*record), 0) << log("tool_log");
}

TEST_F(MalformedPayloads, ADaemonThatReadsRos2GoesOnAndTakesTheGoodReadingsAfterThem) {
  write_file(scratch_ / "d.yaml", "source: {kind: ros2}\nsensor: {id: test}\ndds: {domain: " +
                                      std::to_string(params_.domain) + ", ros2_readings: false}\n");
  MalformedPublisher stranger(params_);
  const auto daemon = start();
  ASSERT_TRUE(says("imu/data_raw")) << log();
  stranger.write_all();
  std::atomic<int> received{0};
  const auto subscriber =
      io::DdsSubscriber::create(params_, {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  const Process driver({ROS2_DRIVER, std::to_string(params_.domain), "4000", "200"});
  EXPECT_TRUE(within_20_s([&] { return received > 20; })) << log();
  EXPECT_EQ(end(*daemon), 0) << log();
}

}  // namespace
}  // namespace stillpoint::test

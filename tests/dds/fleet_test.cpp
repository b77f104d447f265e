/// Several daemons in one domain, each in a namespace of its own, and discovery through a server.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>

#include "io/dds_publisher.h"
#include "io/dds_servers.h"
#include "io/dds_subscriber.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/discovery_server.h"

namespace stillpoint::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string server_address() { return "127.0.0.1:" + std::to_string(server_port()); }

/// One daemon's publisher and one subscriber of it, and whether they have met.
struct Pair {
  Pair(const io::DdsParams& of_publisher, const io::DdsParams& of_subscriber) {
    auto from = io::DdsPublisher::create(of_publisher);
    auto to = io::DdsSubscriber::create(of_subscriber,
                                        {.attitude = [this](const AttitudeMessage&, std::int64_t) { ++received; }});
    EXPECT_TRUE(from && to);
    publisher = std::move(*from);
    subscriber = std::move(*to);
  }
  bool receives() {
    std::uint64_t k = 0;
    return eventually([&] { return publisher->publish(attitude_message(k++)) && received > 20; });
  }
  [[nodiscard]] bool have_met() const { return publisher->attitude_subscribers() > 0 || subscriber->publishers() > 0; }
  std::atomic<int> received{0};
  std::unique_ptr<io::DdsPublisher> publisher;
  std::unique_ptr<io::DdsSubscriber> subscriber;
};

io::DdsParams client(std::vector<std::string> servers) {
  io::DdsParams params = test_params();
  params.discovery_server = std::move(servers);
  return params;
}

TEST(DiscoveryServer, ClientsMeetThroughItEvenIfItStartsLast) {
  Pair pair(client({server_address()}), client({server_address()}));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_FALSE(pair.have_met()) << "they look for nobody but the server";
  const DiscoveryServer server(0, server_port());
  ASSERT_TRUE(server.started());
  EXPECT_TRUE(pair.receives());
  EXPECT_EQ(pair.publisher->neighbours(), io::Neighbours{}) << "the server is no participant that cannot be reached";
  EXPECT_EQ(pair.publisher->refused_datagrams(), io::RefusedDatagrams{});
}

TEST(DiscoveryServer, IsKnownByItsPlaceInTheList) {
  const DiscoveryServer second(1, server_port());
  Pair wrong(client({server_address()}), client({server_address()}));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_FALSE(wrong.have_met()) << "that is the name of id 0";
  Pair right(client({"", server_address()}), client({"", server_address()}));
  EXPECT_TRUE(right.receives());
}

TEST(DiscoveryServer, WhoAsksNoServerIsNotMet) {
  const DiscoveryServer server(0, server_port());
  Pair pair(client({server_address()}), test_params());
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_FALSE(pair.have_met());
}

TEST(DiscoveryServer, AddressesThatCannotBeAreNamed) {
  EXPECT_THAT(check(client({"127.0.0.1", "127.0.0.1:11812"})), IsEmpty());
  EXPECT_EQ(io::parse_server("127.0.0.1")->port, 11811);
  EXPECT_THAT(check(client({"localhost:11811"})), ElementsAre(HasSubstr("'localhost:11811' is no IPv4 address")));
  for (const char* port : {"0", "65536", "", "1x", "-1"})
    EXPECT_THAT(check(client({std::string("127.0.0.1:") + port})), ElementsAre(HasSubstr("1 to 65535"))) << port;
  EXPECT_THAT(check(client({"10.9.8.7:11811"})), ElementsAre(HasSubstr("set 'interface'")));
  EXPECT_THAT(check(client({"", ""})), ElementsAre(HasSubstr("names no server")));
}

TEST(Namespace, OfEachDaemonKeepsTheirTopicsApart) {
  io::DdsParams left = test_params(), right = test_params();
  left.name_space = "robot1/left";
  right.name_space = "robot1/right";
  Pair one(left, left), other(right, right);
  ASSERT_TRUE(one.receives());
  EXPECT_EQ(other.received, 0);
  ASSERT_TRUE(other.receives());
  EXPECT_EQ(one.publisher->neighbours(), io::Neighbours{}) << "no other publishes the same topic";
  EXPECT_EQ(one.publisher->attitude_subscribers(), 1);
  Pair nobody(left, test_params());
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_EQ(nobody.subscriber->publishers(), 0);
}

TEST(Namespace, StandsBeforeEveryTopicOnceAndMustBeAName) {
  io::DdsParams params;
  params.name_space = "robot1";
  params.ros2_namespace = "imu0";
  params.raw_topic = "";
  const io::DdsParams inside = in_namespace(in_namespace(params));
  EXPECT_EQ(inside.attitude_topic, "robot1/stillpoint/attitude");
  EXPECT_EQ(inside.raw_topic, "") << "still not published";
  EXPECT_EQ(inside.ros2_namespace, "robot1/imu0");
  for (const char* bad : {"/robot1", "robot1/", "robot 1", "robot-1"}) {
    params.name_space = bad;
    EXPECT_THAT(check(params), ElementsAre(HasSubstr("namespace '" + std::string(bad) + "'"))) << bad;
  }
}

}  // namespace
}  // namespace stillpoint::test

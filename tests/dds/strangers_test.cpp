/// What strangers in the domain do to a publisher: too much asked for, another type under its name, no goodbye, and
/// datagrams that are no RTPS or damaged RTPS. It says what goes wrong, and goes on serving the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>

#include <atomic>
#include <random>

#include "io/dds_entities.h"
#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/datagram.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/process.h"

namespace stillpoint {
namespace {

namespace dds = io::dds;
using io::Neighbours;
using test::attitude_message;
using test::eventually;
using test::port;
using test::Socket;
using test::test_params;
using Publisher = std::unique_ptr<io::DdsPublisher>;

class Strangers : public testing::Test {
 protected:
  void SetUp() override {
    auto publisher = io::DdsPublisher::create(test_params());
    ASSERT_TRUE(publisher) << publisher.error().message;
    publisher_ = std::move(*publisher);
  }
  static std::unique_ptr<io::DdsEntities> stranger() {
    auto entities = io::DdsEntities::create(test_params(), "udp", "stranger");
    EXPECT_TRUE(entities) << entities.error().message;
    return std::move(*entities);
  }
  /// A subscriber as it should be still gets attitudes.
  void expect_served() {
    std::atomic<int> received{0};
    const auto subscriber = io::DdsSubscriber::create(
        test_params(), {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
    ASSERT_TRUE(subscriber) << subscriber.error().message;
    std::uint64_t k = 0;
    EXPECT_TRUE(eventually([&] { return publisher_->publish(attitude_message(k++)) && received > 20; }));
  }
  Publisher publisher_;
};

TEST_F(Strangers, AloneThereAreNoneAndASecondPublisherIsCountedWhileItIsThere) {
  expect_served();
  EXPECT_EQ(publisher_->neighbours(), Neighbours{});
  auto twin = io::DdsPublisher::create(test_params());
  ASSERT_TRUE(twin) << twin.error().message;
  EXPECT_TRUE(eventually([&] { return publisher_->neighbours() == Neighbours{.publishers = 1}; }));
  EXPECT_TRUE(eventually([&] { return (*twin)->neighbours() == Neighbours{.publishers = 1}; }));
  twin->reset();
  EXPECT_TRUE(eventually([&] { return publisher_->neighbours() == Neighbours{}; }));
}

TEST_F(Strangers, ASubscriberThatAsksForTooMuchIsNamedWithWhatItAsksFor) {
  const auto reliable = stranger();
  ASSERT_TRUE(reliable->reader(test_params().attitude_topic, dds::TypeSupport(new msg::AttitudePubSubType),
                               io::reliable_reader_qos(10, false), nullptr));
  EXPECT_TRUE(eventually([&] { return publisher_->neighbours().refused == 1; }));
  EXPECT_EQ(publisher_->neighbours().asked_for, "reliable delivery; this topic is best effort");

  const auto late = stranger();
  dds::DataReaderQos qos = io::attitude_reader_qos("udp");
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  ASSERT_TRUE(late->reader(test_params().attitude_topic, dds::TypeSupport(new msg::AttitudePubSubType), qos, nullptr));
  EXPECT_TRUE(eventually([&] { return publisher_->neighbours().refused == 2; }));
  EXPECT_THAT(publisher_->neighbours().asked_for, testing::HasSubstr("this topic is volatile"));
  EXPECT_EQ(publisher_->attitude_subscribers(), 0);
  expect_served();
}

TEST_F(Strangers, AnotherTypeUnderTheNameIsCountedAndHeardByNobody) {
  const auto other = stranger();
  const auto writer = other->writer(test_params().attitude_topic, dds::TypeSupport(new msg::RawImuPubSubType),
                                    io::attitude_writer_qos("udp"));
  ASSERT_TRUE(writer) << writer.error().message;
  EXPECT_TRUE(eventually([&] { return publisher_->neighbours() == Neighbours{.of_other_type = 1}; }));
  std::atomic<int> received{0};
  const auto subscriber =
      io::DdsSubscriber::create(test_params(), {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  ASSERT_TRUE(eventually([&] { return (*subscriber)->publishers() == 1; }));
  msg::RawImu reading;
  for (int k = 0; k < 50; ++k) (*writer)->write(&reading);
  expect_served();
  EXPECT_EQ((*subscriber)->publishers(), 1) << "the publisher, not the stranger";
}

TEST_F(Strangers, ASubscriberThatDiesWithoutGoodbyeIsForgottenWhenItsLeaseEnds) {
  test::Process peer({DDS_PEER, "subscribe", std::to_string(test_params().domain), "udp", "60"});
  ASSERT_TRUE(eventually([&] { return publisher_->attitude_subscribers() == 1; }));
  peer.send(SIGKILL);
  peer.wait();
  EXPECT_TRUE(eventually([&] { return publisher_->attitude_subscribers() == 0; })) << "the lease is 5 s";
}

TEST_F(Strangers, RandomBytesAndCutRtpsOnEveryPortDoNoHarm) {
  const std::string announcement = test::announcement();
  ASSERT_EQ(announcement.substr(0, 4), "RTPS");
  const Socket stranger;
  std::mt19937 random(3);
  for (int k = 0; k < 4; ++k) {
    for (std::size_t length = 0; length < announcement.size(); ++length)
      stranger.send(announcement.substr(0, length), port(k));
    for (int n = 0; n < 2000; ++n) {
      std::string bytes(random() % 600, '\0');
      for (char& c : bytes) c = static_cast<char>(random() % 256);
      stranger.send(bytes, port(k));
    }
  }
  expect_served();
  EXPECT_EQ(publisher_->neighbours(), Neighbours{});
}

TEST_F(Strangers, TheDatagramThatAbortsFastDdsStopsAtTheGateAndSubscribersNoticeNothing) {
  std::atomic<int> received{0};
  const auto subscriber =
      io::DdsSubscriber::create(test_params(), {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  ASSERT_TRUE(eventually([&] { return publisher_->attitude_subscribers() == 1 && (*subscriber)->publishers() == 1; }));
  const Socket stranger;
  for (int n = 0; n < 50; ++n) {
    for (int k = 0; k < 6; ++k) stranger.send(test::statistics_datagram(), port(k));
    stranger.send(test::statistics_datagram(), test::group_port());
    publisher_->publish(attitude_message(static_cast<std::uint64_t>(n)));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_TRUE(eventually([&] { return received == 50; })) << received;
  expect_served();
}

/// What Fast DDS reads of tokens makes room for as many properties as are claimed.
TEST_F(Strangers, AnIdentityThatClaimsMoreThanItHoldsStopsAtTheGate) {
  const std::string forged = test::with_boundless_token(test::announcement());
  ASSERT_EQ(forged.substr(0, 4), "RTPS");
  const std::uint64_t before = publisher_->refused_datagrams().malformed;
  const Socket stranger;
  for (int n = 0; n < 10; ++n)
    for (int k = 0; k < 6; ++k) stranger.send(forged, port(k));
  EXPECT_TRUE(eventually([&] { return publisher_->refused_datagrams().malformed >= before + 10; }));
  expect_served();
}

/// Announcements of participants that do not exist, each another one, as fast as they go.
TEST_F(Strangers, AFloodOfParticipantsFromOneProgramIsLeftOutsideAndTheOthersAreServed) {
  std::string announcement = test::announcement();
  ASSERT_EQ(announcement.substr(0, 4), "RTPS");
  const std::string own_prefix = announcement.substr(8, 12);
  std::atomic<int> received{0};
  const auto subscriber =
      io::DdsSubscriber::create(test_params(), {.attitude = [&](const AttitudeMessage&, std::int64_t) { ++received; }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  ASSERT_TRUE(eventually([&] { return publisher_->attitude_subscribers() == 1 && (*subscriber)->publishers() == 1; }));
  const Socket stranger;
  for (int n = 0; n < 3000; ++n) {
    std::string other = own_prefix;
    other[8] = static_cast<char>(n % 256);
    other[9] = static_cast<char>(n / 256);
    other[10] = '\x77';
    std::string forged = announcement;
    for (std::size_t at = 0; (at = forged.find(own_prefix, at)) != std::string::npos; at += 12)
      forged.replace(at, 12, other);
    stranger.send(forged, port(0));
    if (n % 10 == 0) publisher_->publish(attitude_message(static_cast<std::uint64_t>(n)));
    if (n % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(eventually([&] { return received == 300; })) << received;
  const io::RefusedDatagrams refused = publisher_->refused_datagrams();
  EXPECT_EQ(refused.malformed + refused.off_host, 0U);
  EXPECT_GT(refused.flooded, 1000U) << "most; a full socket may lose some before the gate";
  expect_served();
}

}  // namespace
}  // namespace stillpoint

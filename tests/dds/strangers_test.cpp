/// What strangers in the domain do to a publisher: too much asked for, another type under its name, no goodbye, and
/// datagrams that are no RTPS or damaged RTPS. It says what goes wrong, and goes on serving the others.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>
#include <sys/socket.h>

#include <atomic>
#include <random>

#include "io/dds_entities.h"
#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/process.h"

namespace stillpoint {
namespace {

namespace dds = io::dds;
using io::Neighbours;
using test::attitude_message;
using test::eventually;
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

/// A UDP socket on loopback, bound to the port where it is given one.
class Socket {
 public:
  explicit Socket(int port = 0) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in own = address(port);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
  }
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  void send(const std::string& data, int port) const {
    const sockaddr_in to = address(port);
    sendto(fd_, data.data(), data.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  [[nodiscard]] std::string receive() const {
    std::string data(65536, '\0');
    const ssize_t n = recv(fd_, data.data(), data.size(), 0);
    data.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return data;
  }

 private:
  static sockaddr_in address(int port) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_port = htons(static_cast<std::uint16_t>(port));
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return a;
  }
  int fd_;
};

/// Ports of RTPS 9.6: of discovery for even k, of data for odd k, two for each participant of the domain.
int port(int k) { return 7400 + 250 * test_params().domain + 10 + k; }

TEST_F(Strangers, RandomBytesAndCutRtpsOnEveryPortDoNoHarm) {
  // Where the ninth participant would listen for announcements.
  const std::string announcement = Socket(port(16)).receive();
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

}  // namespace
}  // namespace stillpoint

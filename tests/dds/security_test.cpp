/// DDS-Security between participants of our own: who has keys of the same authority is served as ever, who has none or
/// others matches nothing, who is not permitted is refused, and nothing on the wire can be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <thread>

#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/keys.h"
#include "tests/dds/network_namespace.h"
#include "tests/dds/wiretap.h"

namespace stillpoint::test {
namespace {

/// Subscribes to the attitude and the calibration, and keeps what comes.
class Receiver {
 public:
  explicit Receiver(const io::DdsParams& params) {
    auto made =
        io::DdsSubscriber::create(params, {.attitude =
                                               [this](const AttitudeMessage& m, std::int64_t) {
                                                 const std::lock_guard lock(mutex_);
                                                 attitudes_.push_back(m);
                                               },
                                           .calibration = [this](const CalibrationMessage&) { ++calibrations; }});
    EXPECT_TRUE(made) << made.error().message;
    if (made) subscriber_ = std::move(*made);
  }
  [[nodiscard]] std::size_t attitudes() const {
    const std::lock_guard lock(mutex_);
    return attitudes_.size();
  }
  [[nodiscard]] AttitudeMessage last() const {
    const std::lock_guard lock(mutex_);
    return attitudes_.back();
  }
  [[nodiscard]] int publishers() const { return subscriber_->publishers(); }

  std::atomic<int> calibrations{0};

 private:
  mutable std::mutex mutex_;
  std::vector<AttitudeMessage> attitudes_;
  std::unique_ptr<io::DdsSubscriber> subscriber_;  // last: its end stops the callbacks
};

std::unique_ptr<io::DdsPublisher> publisher(const io::DdsParams& params) {
  auto made = io::DdsPublisher::create(params);
  EXPECT_TRUE(made) << made.error().message;
  (*made)->publish_calibration(calibration_message());
  return std::move(*made);
}

/// Publishes until this many have come.
bool receives(io::DdsPublisher& from, const Receiver& at, std::size_t attitudes = 20) {
  std::uint64_t k = 0;
  return eventually([&] { return from.publish(attitude_message(k++)) && at.attitudes() >= attitudes; });
}

/// A receiver that is served. Fast DDS 2.9.1 loses a step of two handshakes in a hundred for good, in whole or for one
/// topic; a new participant is then served (docs/security.md).
std::unique_ptr<Receiver> served(io::DdsPublisher& from, const io::DdsParams& params) {
  std::unique_ptr<Receiver> at;
  for (int attempt = 0; attempt < 4; ++attempt) {
    at = std::make_unique<Receiver>(params);
    if (receives(from, *at) && eventually([&] { return at->calibrations == 1 && at->publishers() == 2; })) return at;
  }
  ADD_FAILURE() << "never served: " << at->attitudes() << " attitudes, " << at->calibrations << " calibrations";
  return at;
}

class Security : public testing::TestWithParam<const char*> {};

TEST_P(Security, KeysOfOneAuthorityAreServedBitForBitAndNobodyElseMatches) {
  const Keys keys("daemon=daemon laptop"), others("stranger");
  const auto from = publisher(with_keys(keys / "daemon", GetParam()));
  const Receiver without(test_params(GetParam())), foreign(with_keys(others / "stranger", GetParam()));
  const auto at = served(*from, with_keys(keys / "laptop", GetParam()));
  ASSERT_FALSE(HasFailure());
  EXPECT_EQ(bits(at->last()), bits(attitude_message(at->last().sequence)));
  std::this_thread::sleep_for(std::chrono::seconds(2));  // four announcements
  EXPECT_TRUE(eventually([&] { return from->attitude_subscribers() == 1; })) << from->attitude_subscribers();
  for (const Receiver* stranger : {&without, &foreign}) {
    EXPECT_EQ(stranger->publishers(), 0);
    EXPECT_EQ(stranger->attitudes(), 0U);
    EXPECT_EQ(stranger->calibrations, 0);
  }
  EXPECT_EQ(from->refused_datagrams().malformed, 0U) << "the gate lets secured datagrams pass";
}

INSTANTIATE_TEST_SUITE_P(Over, Security, testing::Values("udp", "shm"),
                         [](const auto& test) { return std::string(test.param); });

TEST(SecurityOfTheDomain, APublisherWithoutKeysIsNotHeardByWhoHasSome) {
  const Keys keys("daemon=daemon laptop");
  const Receiver at(with_keys(keys / "laptop"));
  const auto stranger = publisher(test_params());
  for (std::uint64_t k = 0; k < 200; ++k) {
    stranger->publish(attitude_message(k));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(stranger->attitude_subscribers(), 0);
  EXPECT_EQ(at.attitudes(), 0U);
  bool heard = false;  // the handshake may be lost, as served() says
  for (int attempt = 0; attempt < 4 && !heard; ++attempt) heard = receives(*publisher(with_keys(keys / "daemon")), at);
  EXPECT_TRUE(heard) << "the same subscriber, and a publisher with keys";
}

TEST(SecurityOfTheDomain, WhoMayOnlyReadCannotPublish) {
  const Keys keys("laptop");
  const auto made = io::DdsPublisher::create(with_keys(keys / "laptop"));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::kUnavailable);
  EXPECT_THAT(made.error().message, testing::HasSubstr("'stillpoint/attitude'"));
  EXPECT_THAT(made.error().message, testing::HasSubstr("permissions"));
}

/// As ROS 2's keystores ask for: every message signed as a whole as well.
TEST(SecurityOfTheDomain, MessagesSignedOrEncryptedAsAWholePassTheGateToo) {
  for (const char* kind : {"SIGN", "ENCRYPT"}) {
    const Keys keys("daemon=daemon laptop");
    keys.edit("ca/governance.xml", "<rtps_protection_kind>NONE", "<rtps_protection_kind>" + std::string(kind));
    keys.make("daemon laptop");
    const auto from = publisher(with_keys(keys / "daemon"));
    EXPECT_NE(served(*from, with_keys(keys / "laptop")), nullptr) << kind;
    EXPECT_EQ(from->refused_datagrams().malformed, 0U) << kind;
  }
}

TEST(SecurityOfTheDomain, WhatIsSentCanBeReadOnTheWireWithoutKeysAndNotWithThem) {
  const NetworkNamespace network;  // the tests that run beside this one are heard on a loopback of their own
  Wiretap wire;
  if (!network.ready() || !wire.ready())
    GTEST_SKIP() << "LOUD: SKIPPED: needs root and the tool `ip` to listen on a loopback";
  const Keys keys("daemon=daemon laptop");
  const std::string said = calibration_message().sensor_id;
  for (const bool secured : {true, false}) {
    const auto from = publisher(secured ? with_keys(keys / "daemon") : test_params());
    const auto at = served(*from, secured ? with_keys(keys / "laptop") : test_params());
    ASSERT_FALSE(HasFailure());
    const std::string seen = wire.take();
    EXPECT_NE(seen.find("RTPS"), std::string::npos);
    EXPECT_EQ(seen.find(said) == std::string::npos, secured);
    EXPECT_EQ(seen.find("stillpoint/attitude") == std::string::npos, secured)
        << "nor is it known what topics there are";
  }
}

}  // namespace
}  // namespace stillpoint::test

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stillpoint_idl/stillpointPubSubTypes.h>

#include <mutex>

#include "io/dds_convert.h"
#include "io/dds_publisher.h"
#include "io/dds_subscriber.h"
#include "tests/dds/dds_testing.h"

namespace stillpoint {
namespace {

using test::attitude_message;
using test::bits;
using test::eventually;
using test::test_params;

class OverTransport : public testing::TestWithParam<const char*> {};

TEST_P(OverTransport, EveryAttitudeArrivesBitForBit) {
  std::mutex mutex;
  std::vector<AttitudeMessage> received;
  auto publisher = io::DdsPublisher::create(test_params(GetParam()));
  ASSERT_TRUE(publisher) << publisher.error().message;
  auto subscriber = io::DdsSubscriber::create(test_params(GetParam()),
                                              {.attitude = [&](const AttitudeMessage& m, std::int64_t t_receive_ns) {
                                                EXPECT_GE(t_receive_ns, m.t_publish_ns);
                                                const std::lock_guard lock(mutex);
                                                received.push_back(m);
                                              }});
  ASSERT_TRUE(subscriber) << subscriber.error().message;
  const auto count = [&] {
    const std::lock_guard lock(mutex);
    return received.size();
  };
  ASSERT_TRUE(
      eventually([&] { return (*publisher)->attitude_subscribers() == 1 && (*subscriber)->publishers() == 1; }));
  constexpr std::uint64_t kMessages = 200;
  for (std::uint64_t k = 0; k < kMessages; ++k) {
    ASSERT_TRUE((*publisher)->publish(attitude_message(k)));
    // Best effort promises nothing to a reader that is behind; here it is given the time.
    ASSERT_TRUE(eventually([&] { return count() == k + 1; })) << "message " << k << " did not arrive";
  }
  for (std::uint64_t k = 0; k < kMessages; ++k)
    EXPECT_EQ(bits(received[k]), bits(attitude_message(k))) << "message " << k;
}

INSTANTIATE_TEST_SUITE_P(Transports, OverTransport, testing::Values("udp", "shm", "data_sharing"),
                         [](const auto& test) { return std::string(test.param); });

TEST(DdsTypes, TheHotTypesArePlainSoThatTheyCanBeLoaned) {
  msg::AttitudePubSubType attitude;
  msg::RawImuPubSubType raw;
  EXPECT_TRUE(attitude.is_plain() && attitude.is_bounded() && !attitude.m_isGetKeyDefined);
  EXPECT_TRUE(raw.is_plain() && raw.is_bounded() && !raw.m_isGetKeyDefined);
  // No gap between the fields, so memory and wire are the same: payload is the struct and four bytes of encapsulation.
  EXPECT_EQ(attitude.m_typeSize, sizeof(msg::Attitude) + 4);
  EXPECT_EQ(raw.m_typeSize, sizeof(msg::RawImu) + 4);
}

TEST(DdsErrors, NameTheValueOrTheInterfaceAndHaveTheirExitCodes) {
  io::DdsParams params = test_params();
  params.transport = "tcp";
  params.interface = "localhost";
  const auto bad = io::DdsPublisher::create(params);
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().kind, ErrorKind::kBadConfig);
  EXPECT_THAT(bad.error().message, testing::HasSubstr("transport 'tcp'"));
  EXPECT_THAT(bad.error().message, testing::HasSubstr("interface 'localhost'"));

  params = test_params();
  params.interface = "192.0.2.77";  // TEST-NET-1: no machine has it
  const auto absent = io::DdsPublisher::create(params);
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().kind, ErrorKind::kUnavailable);
  EXPECT_THAT(absent.error().message, testing::HasSubstr("192.0.2.77"));
}

}  // namespace
}  // namespace stillpoint

/// A program of its own, because it replaces malloc. Without sanitizers, which replace it as well.
#include <gtest/gtest.h>

#include "bench/allocations.h"
#include "io/dds_publisher.h"
#include "tests/dds/dds_testing.h"
#include "tests/dds/process.h"

namespace stillpoint {
namespace {

class Write : public testing::TestWithParam<const char*> {};

TEST_P(Write, OfTenThousandAttitudesToAnotherProcessMakesNoAllocation) {
  const io::DdsParams params = test::test_params(GetParam());
  auto publisher = io::DdsPublisher::create(params);
  ASSERT_TRUE(publisher) << publisher.error().message;
  test::Process subscriber({DDS_PEER, "subscribe", std::to_string(params.domain), GetParam(), "60"});
  ASSERT_TRUE(test::eventually([&] { return (*publisher)->attitude_subscribers() == 1; }));
  ASSERT_FALSE(subscriber.some_output().empty()) << "the subscriber has matched too";
  constexpr std::uint64_t kWarmUp = 500, kCounted = 10'000;
  std::size_t before = 0;
  for (std::uint64_t k = 0; k < kWarmUp + kCounted; ++k) {
    if (k == kWarmUp) before = bench::allocations_of_this_thread();
    ASSERT_TRUE((*publisher)->publish(test::attitude_message(k)));
  }
  EXPECT_EQ(bench::allocations_of_this_thread() - before, 0U);
  EXPECT_EQ((*publisher)->attitude_subscribers(), 1) << "nobody was written to";
  const std::size_t before_reliable = bench::allocations_of_this_thread();
  ASSERT_TRUE((*publisher)->publish_raw(test::raw_sample(0), 0));
  EXPECT_GT(bench::allocations_of_this_thread(), before_reliable) << "the counter does not see Fast DDS's own mallocs";
}

// Not over shm: Fast DDS 2.9 allocates three times a write there (docs/decisions/060-dds.md).
INSTANTIATE_TEST_SUITE_P(Transports, Write, testing::Values("udp", "data_sharing"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace stillpoint

#include "apps/stillpointd/rate_meter.h"

#include <gtest/gtest.h>

namespace stillpoint {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(RateMeter, CountsBetweenTwoLooks) {
  app::RateMeter rate(10 * kSecond_ns);
  EXPECT_DOUBLE_EQ(rate.look(400, 11 * kSecond_ns), 400.0);
  EXPECT_DOUBLE_EQ(rate.look(600, 13 * kSecond_ns), 100.0);
}

TEST(RateMeter, ALookTooSoonRepeatsTheLastAndLosesNoSample) {
  app::RateMeter rate(0);
  EXPECT_DOUBLE_EQ(rate.look(400, kSecond_ns), 400.0);
  EXPECT_DOUBLE_EQ(rate.look(420, kSecond_ns + 11'000'000), 400.0) << "a batch of 20 in 11 ms is no rate of 1800 Hz";
  EXPECT_DOUBLE_EQ(rate.look(800, 2 * kSecond_ns), 400.0);
}

}  // namespace
}  // namespace stillpoint

/// When what is gone is tried again.
#include "sources/reopening.h"

#include <gtest/gtest.h>

namespace stillpoint::sources {
namespace {

TEST(Reopening, WaitsTwiceAsLongEachTimeUpToItsBoundAndShortlyAgainOnceItWorked) {
  Reopening again(0.5);
  std::int64_t now_ns = 7;
  const auto wait_ns = [&] {
    again.failed(now_ns);
    const std::int64_t wait = again.next_ns() - now_ns;
    EXPECT_FALSE(again.due(again.next_ns() - 1));
    EXPECT_TRUE(again.due(again.next_ns()));
    now_ns = again.next_ns();
    return wait;
  };
  for (const std::int64_t tenths : {1, 2, 4, 5, 5}) EXPECT_EQ(wait_ns(), tenths * Reopening::kFirst_ns);
  again.works();
  EXPECT_EQ(wait_ns(), Reopening::kFirst_ns);
}

}  // namespace
}  // namespace stillpoint::sources

#include "diagnosis/reference/fast_length.h"

#include <gtest/gtest.h>

namespace stillpoint::diag {
namespace {

TEST(FastLength, IsAProductOfTwoThreeAndFiveBesideTheNumberAskedFor) {
  EXPECT_EQ(fast_length_within(56381), 56250);  // 13 times a prime
  EXPECT_EQ(fast_length_from(56381), 57600);
  for (const Eigen::Index fast : {1, 2, 3, 5, 3000, 6000, 7200}) {
    EXPECT_EQ(fast_length_within(fast), fast);
    EXPECT_EQ(fast_length_from(fast), fast);
  }
}

}  // namespace
}  // namespace stillpoint::diag

#include "tests/apps/dds_equality.h"

namespace stillpoint::test {
namespace {

TEST(DaemonOverDds, AtRealTimeNoSampleIsLostAndEachIsTheOfflineOneBitForBit) {
  if (!std::filesystem::exists(handheld())) GTEST_SKIP() << "LOUD: SKIPPED, recording absent: " << handheld();
  EXPECT_EQ(share_received_bit_for_bit(1.0), 1.0);
}

}  // namespace
}  // namespace stillpoint::test

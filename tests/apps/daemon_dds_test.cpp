#include "tests/apps/dds_equality.h"

namespace stillpoint::test {
namespace {

TEST(DaemonOverDds, AtTwentyTimesRealTimeTheAttitudeReceivedIsTheOfflineOneBitForBit) {
  if (!std::filesystem::exists(handheld())) GTEST_SKIP() << "LOUD: SKIPPED, recording absent: " << handheld();
  const double share = share_received_bit_for_bit(20.0);
  // 2000 messages a second, best effort, on a machine that may be busy: some may be lost, none may differ.
  EXPECT_GT(share, 0.9);
  RecordProperty("share_received", std::to_string(share));
}

}  // namespace
}  // namespace stillpoint::test

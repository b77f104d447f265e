#include <gtest/gtest.h>

#include "sources/splitter.h"
#include "tests/dds/process.h"
#include "tests/source_folder.h"
#include "tests/sources/sources_testing.h"

namespace stillpoint::sources {
namespace {

TEST(Sender, TheOneOfTheDocumentsIsCompiledAndUnderstood) {
  const test::ScratchFolder folder;
  test::Process compiler(
      {"/usr/bin/cc", "-Wall", "-Wextra", "-Werror", "-o", folder / "send", in_source("docs/senders/send_frames.c")});
  ASSERT_EQ(compiler.wait(), 0);
  test::Process sender({folder / "send", "2000", "400"});
  const std::string bytes = sender.output();
  ASSERT_EQ(sender.wait(), 0);
  Splitter splitter({});
  std::string_view rest = bytes;
  int readings = 0;
  while (!rest.empty()) {
    const std::size_t n = std::min(rest.size(), splitter.room().size());
    std::copy_n(rest.data(), n, splitter.room().data());
    splitter.received(n);
    rest.remove_prefix(n);
    Reading reading;
    std::uint64_t steps = 0;
    for (; splitter.next(reading, steps) == Piece::kReading; ++readings) {
      EXPECT_EQ(reading.sample.has, kAcc | kGyr);
      EXPECT_NEAR(reading.sample.acc_mps2[2], 9.80665, 1e-5);
      EXPECT_TRUE(reading.has_time);
      EXPECT_EQ(steps, 1U);
    }
  }
  EXPECT_EQ(readings, 400);
  EXPECT_EQ(splitter.counts().malformed, 0U);
}

}  // namespace
}  // namespace stillpoint::sources

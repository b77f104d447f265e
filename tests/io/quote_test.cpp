#include "io/quote.h"

#include <gtest/gtest.h>

namespace stillpoint::io {
namespace {

TEST(Quote, TakesTheTerminalsControlCharactersOut) {
  EXPECT_EQ(printable("at rest \x1b[2J\r\n\x7f\xff"), "at rest ?[2J????");
  EXPECT_EQ(quote("a\tb"), "'a?b'");
}

TEST(Quote, CutsWhatWouldFloodTheTerminal) {
  EXPECT_EQ(printable("four", 4), "four");
  EXPECT_EQ(printable("fives", 4), "five...");
  EXPECT_EQ(quote(std::string(61, 'x')), "'" + std::string(60, 'x') + "...'");
}

}  // namespace
}  // namespace stillpoint::io

#include "io/quote.h"

#include <gtest/gtest.h>

namespace stillpoint::io {
namespace {

TEST(Quote, TakesTheTerminalsControlCharactersOut) {
  EXPECT_EQ(printable("at rest \x1b[2J\r\n\x7f\xff"), "at rest ?[2J????");
  EXPECT_EQ(quote("a\tb"), "'a?b'");
}

TEST(Quote, AMessageKeepsItsLinesAndItsLettersAndLosesWhatSteersATerminal) {
  EXPECT_EQ(without_controls("f.zip:a\x1b[2J.csv: cut\nno column '\xc2\xb5T\t'\r\x7f"),
            "f.zip:a?[2J.csv: cut\nno column '\xc2\xb5T?'??");
  EXPECT_EQ(without_controls("\xc2\x9b"
                             "2J\xc2"),
            "?2J\xc2")
      << "CSI as one character of UTF-8";
}

TEST(Quote, CutsWhatWouldFloodTheTerminal) {
  EXPECT_EQ(printable("four", 4), "four");
  EXPECT_EQ(printable("fives", 4), "five...");
  EXPECT_EQ(quote(std::string(61, 'x')), "'" + std::string(60, 'x') + "...'");
}

}  // namespace
}  // namespace stillpoint::io

#include "sources/splitter.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace stillpoint::sources {
namespace {

constexpr const char* kPlainHeader = "time_us,acc_x_mps2,acc_y_mps2,acc_z_mps2\n";

/// Feeds the bytes in pieces of at most `most`; what came out.
std::vector<Reading> feed(Splitter& splitter, std::string_view bytes, std::size_t most, std::uint64_t* all_steps = {}) {
  std::vector<Reading> out;
  while (!bytes.empty()) {
    const auto room = splitter.room();
    const std::size_t n = std::min({most, room.size(), bytes.size()});
    EXPECT_GT(n, 0U);
    std::copy_n(bytes.data(), n, room.data());
    splitter.received(n);
    bytes.remove_prefix(n);
    Reading reading;
    std::uint64_t steps = 0;
    while (splitter.next(reading, steps) == Piece::kReading) {
      out.push_back(reading);
      if (all_steps != nullptr) *all_steps += steps;
    }
  }
  return out;
}

std::string line(int k) { return std::to_string(k) + ",0,0,9.8\n"; }

std::string frame(int k) {
  Reading r;
  r.has_time = true;
  r.sample.t_ns = k * 1000;
  r.sample.has = kAcc;
  r.sample.acc_mps2 = {0, 0, 9.75};
  std::array<std::uint8_t, kLongestFrame> bytes{};
  const std::size_t n = write_frame(r, static_cast<std::uint8_t>(k), bytes);
  return {reinterpret_cast<const char*>(bytes.data()), n};
}

TEST(Splitter, LinesComeOutWholeHoweverTheyArrive) {
  std::string text = kPlainHeader;
  for (int k = 1; k <= 500; ++k) text += line(k);
  for (const std::size_t most : {1U, 7U, 100U, 8192U}) {
    Splitter splitter({});
    const auto got = feed(splitter, text, most);
    ASSERT_EQ(got.size(), 500U) << most;
    for (int k = 1; k <= 500; ++k) ASSERT_EQ(got[static_cast<std::size_t>(k - 1)].sample.t_ns, k * 1000);
    EXPECT_EQ(splitter.counts().malformed, 0U);
  }
}

TEST(Splitter, ADamagedLineCostsItselfAndIsAGapOfTheSequence) {
  Splitter splitter({});
  std::uint64_t steps = 0;
  const auto got = feed(splitter, kPlainHeader + line(1) + "2,0,\n" + line(3), 5, &steps);
  ASSERT_EQ(got.size(), 2U);
  EXPECT_EQ(steps, 3U);
  EXPECT_EQ(splitter.counts().malformed, 1U);
  EXPECT_EQ(splitter.last_refused(), "2,0,");
}

TEST(Splitter, TheFirstLineOfALineJoinedInItsMidstIsNotTrusted) {
  Splitter splitter({});
  feed(splitter, kPlainHeader + line(1000), 100);
  splitter.restart(true);
  const auto got = feed(splitter, "2,0,0,9.8\n" + line(2003), 100);  // "2" is the rest of "2002"
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].sample.t_ns, 2'003'000);
}

TEST(Splitter, ALineWithoutEndIsPassedOver) {
  Splitter splitter({});
  feed(splitter, kPlainHeader, 100);
  const auto got = feed(splitter, std::string(20'000, '7') + "\n" + line(5), 4096);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_GE(splitter.counts().skipped_bytes, 8192U);
}

TEST(Splitter, AHeaderWithoutAKnownNameIsTold) {
  Splitter splitter({});
  feed(splitter, "rst:0x1 (POWERON),boot:0x13,mode:DIO,clock\nHello\n", 100);
  EXPECT_EQ(splitter.unknown_names(), "");
  feed(splitter, "t,accx_g,acc_y,acc_z\n1,0,0,1\n", 100);
  EXPECT_NE(splitter.unknown_names().find("t, accx_g (acc_x_g?), "), std::string::npos) << splitter.unknown_names();
  feed(splitter, kPlainHeader + line(1), 100);
  EXPECT_EQ(splitter.unknown_names(), "");
}

TEST(Splitter, LinesThatEndWithACarriageReturnAloneAreTold) {
  for (const bool alone : {true, false}) {
    Splitter splitter({});
    std::string text = kPlainHeader;
    for (int k = 0; k < 1000; ++k) text += line(k);
    std::string with_returns;
    for (const char c : text) with_returns += c != '\n' ? std::string(1, c) : alone ? "\r" : "\r\n";
    feed(splitter, with_returns, 100);
    EXPECT_EQ(splitter.counts().returns_alone, alone);
  }
}

TEST(Splitter, FramesAreFoundByThemselvesAndAgainAfterGarbage) {
  Splitter splitter({});
  std::string bytes = "boot: sensor 1\n";
  for (int k = 0; k < 400; ++k) {
    if (k == 100) bytes += std::string("\xA5\x5A\x11garbage\xA5", 11);
    if (k == 200) bytes += frame(k).substr(0, 9);  // cut, and the next one follows
    if (k != 200) bytes += frame(k);
  }
  for (const std::size_t most : {1U, 13U, 4096U}) {
    Splitter fresh({});
    std::uint64_t steps = 0;
    const auto got = feed(fresh, bytes, most, &steps);
    EXPECT_EQ(got.size(), 399U) << most;
    EXPECT_EQ(fresh.counts().lost, 1U) << most;
    EXPECT_EQ(steps, 400U) << most;
    EXPECT_GT(fresh.counts().malformed, 0U);
  }
}

TEST(Splitter, AnythingAtAllIsSurvived) {
  std::mt19937 random(1);
  const std::string pieces[] = {line(1),
                                frame(2),
                                kPlainHeader,
                                R"({"acc_g":[0,0,1]})"
                                "\n",
                                "\xA5\x5A",
                                "\n",
                                ",,,,",
                                "{\"a\":",
                                std::string(3, '\0')};
  for (int run = 0; run < 300; ++run) {
    std::string bytes;
    for (int k = 0; k < 60; ++k) bytes += pieces[random() % std::size(pieces)];
    for (int k = 0; k < 20; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    io::StreamParams params;
    params.format = static_cast<io::StreamFormat>(run % 3);
    Splitter splitter(params);
    for (const auto& reading : feed(splitter, bytes, 1 + random() % 200)) ASSERT_NE(reading.sample.has, 0);
  }
}

TEST(Splitter, ARowAtATimeThatIsNoneIsCountedAndIsAGapOfTheSequence) {
  Splitter splitter({});
  std::uint64_t steps = 0;
  const auto got = feed(splitter, std::string(kPlainHeader) + line(1) + "17e17,0,0,9.8\n" + line(3), 100, &steps);
  EXPECT_EQ(got.size(), 2U);
  EXPECT_EQ(steps, 3U);
  EXPECT_EQ(splitter.counts().times_refused, 1U);
  EXPECT_EQ(splitter.counts().malformed, 0U);
  EXPECT_DOUBLE_EQ(splitter.counts().refused_time, 17e17);
  EXPECT_DOUBLE_EQ(splitter.counts().refused_time_unit_ns, 1e3);
}

TEST(Splitter, SaysWhatLinesThatAreNoReadingsLookLike) {
  const auto look = [](const std::string& text) {
    Splitter splitter({});
    feed(splitter, kPlainHeader + text, 100);
    return splitter.look();
  };
  EXPECT_EQ(look("5;0,5;0,25;9,81\n"), LineLook::kDecimalCommas);
  EXPECT_EQ(look("5,0,05,0,25,9,81\n"), LineLook::kDecimalCommas);
  EXPECT_EQ(look("2026-01-31T10:20:30.5Z,0,0,9.8\n"), LineLook::kDate);
  EXPECT_EQ(look("10:20:30.5,0,0,9.8\n"), LineLook::kDate);
  EXPECT_EQ(look("[{\"time_us\": 5, \"temp_degC\": 20},\n"), LineLook::kJsonArray);
  EXPECT_EQ(look("{\"time_us\": 5, \"temp_degC\": 20},\n"), LineLook::kJsonArray);
  for (const char* damaged : {"5,0,0\n", "5,0,0,9.8,5,0,0,9.8\n", "[INFO] ready\n", "{\"acc_g\": [0, 0,\n", "x;y\n"})
    EXPECT_EQ(look(damaged), LineLook::kUnknown) << damaged;
}

TEST(Splitter, AHeaderBesideAConfiguredListIsReadForItsContradiction) {
  io::StreamParams params;
  params.columns = {{"time_us", "1"}, {"acc_x_mps2", "2"}, {"acc_y_mps2", "4"}, {"acc_z_mps2", "3"}};
  Splitter splitter(params);
  EXPECT_EQ(feed(splitter, std::string(kPlainHeader) + line(1), 100).size(), 1U) << "the list serves";
  EXPECT_EQ(splitter.header_faults().substr(0, 40), "column 3 is acc_y_mps2 in the header lin");
  EXPECT_EQ(splitter.unknown_names(), "");
}

}  // namespace
}  // namespace stillpoint::sources

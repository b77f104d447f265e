#include "sources/frame.h"

#include <gtest/gtest.h>

#include <vector>

namespace stillpoint::sources {
namespace {

Reading example() {
  Reading r;
  r.has_time = true;
  r.sample.t_ns = 5'000'000'000'000;  // beyond 2^32 us: wraps on the wire
  r.sample.has = kAcc | kGyr | kMag | kTemp;
  r.sample.acc_mps2 = {0.5, -0.25, 9.75};
  r.sample.gyr_radps = {1, 2, 3};
  r.sample.mag_uT = {20, 0, -43};
  r.sample.temp_degC = 36.5;
  return r;
}

std::vector<std::uint8_t> bytes_of(const Reading& r, std::uint8_t counter) {
  std::array<std::uint8_t, kLongestFrame> out{};
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(write_frame(r, counter, out))};
}

TEST(Frame, CrcIsThatOfTheStandardsCheckWord) {
  const std::string check = "123456789";
  EXPECT_EQ(crc16({reinterpret_cast<const std::uint8_t*>(check.data()), check.size()}), 0x29B1);  // CRC-16/IBM-3740
}

TEST(Frame, ComesBackAsItWasSent) {
  const auto bytes = bytes_of(example(), 7);
  ASSERT_EQ(bytes.size(), kLongestFrame);
  const Frame frame = take_frame(bytes);
  ASSERT_EQ(frame.piece, Piece::kReading);
  EXPECT_EQ(frame.size, bytes.size());
  EXPECT_EQ(frame.counter, 7);
  EXPECT_EQ(frame.reading.sample.acc_mps2, example().sample.acc_mps2);
  EXPECT_EQ(frame.reading.sample.mag_uT, example().sample.mag_uT);
  EXPECT_EQ(frame.reading.sample.temp_degC, 36.5);
  EXPECT_EQ(frame.reading.sample.t_ns, 5'000'000'000'000 % 4'294'967'296'000);
}

TEST(Frame, APartOfOneIsWaitedForAndNeverTaken) {
  const auto bytes = bytes_of(example(), 7);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    const Frame frame = take_frame(std::span(bytes).first(n));
    EXPECT_EQ(frame.piece, Piece::kNone) << n;
    EXPECT_EQ(frame.size, 0U) << n;
  }
}

TEST(Frame, OneWrongBitAnywhereIsSeen) {
  const auto good = bytes_of(example(), 7);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    auto bytes = good;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    bytes.resize(2 * bytes.size());  // a wrong length must not make it wait for ever
    EXPECT_NE(take_frame(bytes).piece, Piece::kReading) << bit;
  }
}

}  // namespace
}  // namespace stillpoint::sources

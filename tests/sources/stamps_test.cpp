#include "sources/stamps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace stillpoint::sources {
namespace {

Reading reading(bool has_time = false, std::int64_t t_ns = 0, double unit_ns = 1.0, std::uint8_t has = kAcc | kGyr) {
  Reading r;
  r.sample.has = has;
  r.sample.t_ns = t_ns;
  r.has_time = has_time;
  r.time_unit_ns = unit_ns;
  return r;
}

TEST(Stamps, ArrivalsThroughAUsbSerialChipAreMadeEven) {
  // 200 Hz behind a latency timer of 16 ms: readings come in bursts of three or four.
  Stamps stamps(0.0);
  std::vector<double> error_ms;
  std::int64_t last = 0;
  for (int k = 0; k < 4000; ++k) {
    const double sent_ms = 5.0 * k;
    const double arrival_ms = 16.0 * std::ceil((sent_ms + 0.1) / 16.0);
    Reading r = reading();
    if (!stamps.stamp(r, std::llround(1e6 * arrival_ms), 1)) continue;
    ASSERT_GT(r.sample.t_ns, last);
    last = r.sample.t_ns;
    if (k >= 2500) error_ms.push_back(1e-6 * static_cast<double>(r.sample.t_ns) - sent_ms);
  }
  ASSERT_EQ(error_ms.size(), 1500U);
  double mean = 0.0, worst = 0.0;
  for (const double e : error_ms) mean += e / static_cast<double>(error_ms.size());
  for (const double e : error_ms) worst = std::max(worst, std::abs(e - mean));
  EXPECT_NEAR(mean, 8.0, 1.0) << "the mean delay of the chip, which nobody can know";
  EXPECT_LT(worst, 0.5) << "raw arrivals are off by 8 ms";
}

/// What has waited for nothing is as old as it arrives, to the nanosecond.
TEST(Stamps, TheFirstReadingAndThatAfterAPauseComeWhenTheyArrive) {
  Stamps stamps(100.0);
  Reading r = reading();
  std::int64_t at_ns = 1'000;
  ASSERT_TRUE(stamps.stamp(r, at_ns, 1));
  EXPECT_EQ(r.sample.t_ns, at_ns);
  for (int k = 0; k < 50; ++k) stamps.stamp(r = reading(), at_ns += 10'000'000, 1);
  ASSERT_TRUE(stamps.stamp(r = reading(), at_ns += 30'000'000'000, 1));
  EXPECT_EQ(r.sample.t_ns, at_ns);
}

TEST(Stamps, APauseIsKeptAndALostReadingLeavesItsPlace) {
  ArrivalClock clock(100.0);
  std::int64_t t = 0, before = 0;
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(clock.stamp(10'000'000LL * k, 1, t));
  before = t;
  ASSERT_TRUE(clock.stamp(10'000'000LL * 301, 2, t));
  EXPECT_NEAR(static_cast<double>(t - before), 20e6, 1e5);
  before = t;
  ASSERT_TRUE(clock.stamp(10'000'000LL * 801, 1, t));
  EXPECT_NEAR(static_cast<double>(t - before), 5e9, 1e6);
}

TEST(Stamps, ABurstAfterAnInterruptionOfTheMachineIsSpreadOverTheTimeThatItTook) {
  ArrivalClock clock(100.0);
  std::int64_t t = 0, last = 0;
  for (int k = 0; k < 400; ++k) {
    const bool stalled = k >= 300 && k < 320;
    ASSERT_TRUE(clock.stamp(10'000'000LL * (stalled ? 320 : k), 1, t));
    if (k > 0) {
      ASSERT_NEAR(static_cast<double>(t - last), 10e6, 3e6) << k;
    }
    last = t;
  }
}

TEST(Stamps, SensorsThatComeOneByOneHaveRatesOfTheirOwn) {
  Stamps stamps(0.0);
  std::int64_t last_acc = 0, last_mag = 0;
  for (int ms = 0; ms < 4000; ms += 5) {
    Reading acc = reading(false, 0, 1.0, kAcc), mag = reading(false, 0, 1.0, kMag);
    if (stamps.stamp(acc, 1'000'000LL * ms, 1) && ms > 2000) {
      EXPECT_NEAR(static_cast<double>(acc.sample.t_ns - last_acc), 5e6, 1e3);
    }
    last_acc = acc.sample.t_ns;
    if (ms % 50 != 0) continue;
    if (stamps.stamp(mag, 1'000'000LL * ms, 1) && ms > 2000) {
      EXPECT_NEAR(static_cast<double>(mag.sample.t_ns - last_mag), 50e6, 1e4);
    }
    last_mag = mag.sample.t_ns;
  }
}

TEST(Stamps, ACounterOf32BitsIsFollowedOverItsEnd) {
  Stamps stamps(0.0);
  std::int64_t last = 0;
  for (std::int64_t us = 4'294'900'000; us < 4'295'100'000; us += 10'000) {
    Reading r = reading(true, (us % 4'294'967'296) * 1000, 1000.0);
    ASSERT_TRUE(stamps.stamp(r, us * 1000, 1));
    if (last != 0) {
      ASSERT_EQ(r.sample.t_ns - last, 10'000'000);
    }
    last = r.sample.t_ns;
  }
}

TEST(Stamps, ALateRowFromBeforeTheEndOf32BitsIsNoSecondEnd) {
  constexpr std::int64_t kRound = 4'294'967'296;
  for (const double unit_ns : {1.0, 1e3, 1e6}) {
    Stamps stamps(0.0);
    std::int64_t at = 0;
    for (const std::int64_t from_the_end : {-5, -1, -3, 1, -2, -1, 6, -4, -1, 11, 8}) {
      Reading r = reading(true, (kRound + from_the_end) % kRound * std::llround(unit_ns), unit_ns);
      ASSERT_TRUE(stamps.stamp(r, at += 1'000'000, 1));
      EXPECT_EQ(r.sample.t_ns, (kRound + from_the_end) * std::llround(unit_ns)) << from_the_end << ' ' << unit_ns;
    }
  }
}

TEST(Stamps, ASenderThatBeganAnewGoesOnWhereItWouldBe) {
  Stamps stamps(0.0);
  Reading r = reading(true, 50'000'000'000);
  ASSERT_TRUE(stamps.stamp(r, 1'000'000'000, 1));
  stamps.restart();
  r = reading(true, 20'000'000);
  ASSERT_TRUE(stamps.stamp(r, 4'000'000'000, 1));
  EXPECT_EQ(r.sample.t_ns, 53'000'000'000);
  r = reading(true, 30'000'000);
  ASSERT_TRUE(stamps.stamp(r, 4'010'000'000, 1));
  EXPECT_EQ(r.sample.t_ns, 53'010'000'000);
  stamps.restart();  // a cable alone: the sender has gone on counting
  r = reading(true, 9'030'000'000);
  ASSERT_TRUE(stamps.stamp(r, 13'000'000'000, 1));
  EXPECT_EQ(r.sample.t_ns, 62'010'000'000);
}

/// 100 readings a second, the last of them stamped 20 s.
struct Stream {
  Stamps stamps{0.0};
  Reading out;
  std::int64_t arrival_ns = 0;

  Stream() {
    for (std::int64_t ms = 10'000; ms <= 20'000; ms += 10) EXPECT_TRUE(push(10, ms)) << ms;
  }
  bool push(std::int64_t after_ms, std::int64_t sender_ms) {
    arrival_ns += 1'000'000 * after_ms;
    out = reading(true, 1'000'000 * sender_ms);
    return stamps.stamp(out, arrival_ns, 1);
  }
  [[nodiscard]] std::int64_t ms() const { return out.sample.t_ns / 1'000'000; }
};

TEST(Stamps, ASenderThatBeganAnewOnAStreamThatWasNotCutIsMissedForAsLongAsNothingArrived) {
  Stream stream;
  EXPECT_FALSE(stream.push(3'000, 200)) << "one alone may be damaged";
  ASSERT_TRUE(stream.push(10, 210));
  EXPECT_EQ(stream.ms(), 23'010);
  ASSERT_TRUE(stream.push(10, 220));
  EXPECT_EQ(stream.ms(), 23'020);
  EXPECT_EQ(stream.stamps.began_anew(), 1U);
  EXPECT_EQ(stream.stamps.away_ns(), 3'000'000'000);
}

TEST(Stamps, AClockThatJumpsWhileReadingsComeIsLeftToThePipeline) {
  Stream stream;
  for (std::int64_t ms = 200; ms < 400; ms += 10) {
    ASSERT_TRUE(stream.push(10, ms));
    EXPECT_EQ(stream.ms(), ms);
  }
  EXPECT_EQ(stream.stamps.began_anew(), 0U);
}

TEST(Stamps, AClockThatJumpsBetweenTwoBurstsIsLeftToThePipeline) {
  Stamps stamps(0.0);
  for (int k = 0; k < 400; ++k) {
    Reading r = reading(true, 10'000'000LL * (k < 304 ? k + 2000 : k));
    ASSERT_TRUE(stamps.stamp(r, 160'000'000LL * (k / 16), 1)) << k;
  }
  EXPECT_EQ(stamps.began_anew(), 0U);
}

TEST(Stamps, OneStampThatLiesBehindAfterAPauseIsRefusedAlone) {
  Stream stream;
  EXPECT_FALSE(stream.push(3'000, 5));
  ASSERT_TRUE(stream.push(10, 23'010));
  EXPECT_EQ(stream.ms(), 23'010);
  EXPECT_FALSE(stream.push(500, 7));
  ASSERT_TRUE(stream.push(10, 9'000)) << "neither of them is near the other";
  EXPECT_EQ(stream.ms(), 9'000);
}

TEST(Stamps, ALateRowAfterAPauseIsNoSenderThatBeganAnew) {
  Stream stream;
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(stream.push(k == 0 ? 400 : 0, 19'960 + k));
    EXPECT_EQ(stream.ms(), 19'960 + k);
  }
}

TEST(Stamps, TimesThatAddUpBeyondAnyClockAreRefused) {
  constexpr std::int64_t kFar_ns = 3'900'000'000'000'000'000;
  Stamps stamps(0.0);
  Reading r = reading(true, kFar_ns);
  ASSERT_TRUE(stamps.stamp(r, 0, 1));
  stamps.restart();
  r = reading(true, 1);
  ASSERT_TRUE(stamps.stamp(r, 1, 1)) << "goes on where it was";
  r = reading(true, kFar_ns);
  EXPECT_FALSE(stamps.stamp(r, 2, 1)) << "247 years: its difference from another time may not fit";
  stamps.restart();
  r = reading(true, -kFar_ns);
  ASSERT_TRUE(stamps.stamp(r, 3, 1));
  EXPECT_EQ(r.sample.t_ns, 0) << "nothing that fits would advance";
}

TEST(Stamps, AReadingWithoutATimeAmongOthersThatHaveOneIsDamaged) {
  Stamps stamps(100.0);
  Reading r = reading(true, 5);
  ASSERT_TRUE(stamps.stamp(r, 0, 1));
  r = reading();
  EXPECT_FALSE(stamps.stamp(r, 1, 1));
  r = reading(true, 9'000'000'000'000'000'000);
  EXPECT_FALSE(stamps.stamp(r, 1, 1)) << "no two such times can be told apart in 64 bits";
}

}  // namespace
}  // namespace stillpoint::sources

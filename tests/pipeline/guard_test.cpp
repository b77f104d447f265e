/// What the guard counts and how well it knows the sensors' own times.
#include "pipeline/guard_stage.h"

#include <gtest/gtest.h>

namespace stillpoint::pipeline {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;

/// Rows with a sequence of their own, alive in every axis.
struct Rows {
  GuardStage guard;
  GuardedSample out;
  std::int64_t t_ns = 0;
  std::uint64_t sequence = 0;

  StageStatus push(std::int64_t step_ns, std::uint64_t steps = 1, std::uint8_t has = kAcc | kGyr) {
    t_ns += step_ns;
    sequence += steps;
    const double live = 0.01 * static_cast<double>(sequence % 7);
    return guard.process({.t_ns = t_ns,
                          .sequence = sequence,
                          .acc_mps2 = {live, 0.0, 9.8},
                          .gyr_radps = {0.0, live, 0.0},
                          .mag_uT = {20.0, live, -40.0},
                          .temp_degC = 30.0,
                          .has = has},
                         out);
  }
};

TEST(Guard, CountsEverySampleThatIsMissingInTheSequence) {
  Rows rows;
  rows.sequence = 1000;  // where a source begins to count is its own affair
  for (int k = 0; k < 10; ++k) rows.push(10 * kMillisecond_ns);
  EXPECT_EQ(rows.guard.counts().lost, 0U);
  EXPECT_EQ(rows.push(10 * kMillisecond_ns, 2), StageStatus::kDegraded);
  EXPECT_TRUE(rows.out.after_gap);
  EXPECT_EQ(rows.guard.counts().lost, 1U);
  EXPECT_EQ(rows.push(10 * kMillisecond_ns), StageStatus::kOk);
  rows.push(10 * kMillisecond_ns, 43);
  EXPECT_EQ(rows.guard.counts().lost, 43U);
  EXPECT_EQ(rows.guard.counts().gaps, 2U);
  EXPECT_EQ(rows.guard.counts().samples, 13U);
}

TEST(Guard, CountsTheRowsThatAreRefusedForTheirTimeApart) {
  Rows rows;
  for (int k = 0; k < 10; ++k) rows.push(10 * kMillisecond_ns);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(rows.push(0), StageStatus::kDrop);
  EXPECT_EQ(rows.push(10 * kMillisecond_ns, 1, kAcc), StageStatus::kOk);
  EXPECT_EQ(rows.push(0, 1, kAcc), StageStatus::kDrop) << "in a row of its own";
  RawSample broken{
      .t_ns = rows.t_ns + kMillisecond_ns, .sequence = rows.sequence + 1, .acc_mps2 = {1e300, 0, 0}, .has = kAcc};
  EXPECT_EQ(rows.guard.process(broken, rows.out), StageStatus::kDrop);
  broken.has = 0;
  rows.guard.process(broken, rows.out);
  EXPECT_EQ(rows.guard.counts().rows, 17U);
  EXPECT_EQ(rows.guard.counts().refused, 6U);
  EXPECT_EQ(rows.guard.counts().out_of_time, 5U);
}

TEST(Guard, KnowsTheUsualStepOfEverySensorThoughTheFirstWasLongAndSomeAreMissing) {
  Rows rows;
  EXPECT_EQ(rows.guard.usual_step_s(), 0.0);
  rows.push(10 * kMillisecond_ns);
  rows.push(100 * kMillisecond_ns);
  for (int k = 1; k <= 2000; ++k) {
    unsigned has = kAcc | kGyr;
    if (k % 5 == 0) has |= kMag;
    if (k % 10 == 0) has |= kTemp;
    rows.push(k % 20 == 0 ? 30 * kMillisecond_ns : 10 * kMillisecond_ns, 1, static_cast<std::uint8_t>(has));
  }
  // Each step moves it by 2 %.
  EXPECT_NEAR(rows.guard.usual_step_s(), 0.010, 0.0005);
  const auto steps_s = rows.guard.usual_steps_s();
  EXPECT_NEAR(steps_s[part_index(kAcc)], 0.010, 0.0005);
  EXPECT_NEAR(steps_s[part_index(kGyr)], 0.010, 0.0005);
  EXPECT_NEAR(steps_s[part_index(kMag)], 0.050, 0.0025);
  EXPECT_NEAR(steps_s[part_index(kTemp)], 0.110, 0.015);  // every other one holds a gap: 100 and 120 ms
}

TEST(Guard, AGapIsAStepLongerThanSoManyUsualOnes) {
  Rows rows;
  for (int k = 0; k < 200; ++k) rows.push(10 * kMillisecond_ns);
  rows.push(24 * kMillisecond_ns);
  EXPECT_FALSE(rows.out.after_gap);
  EXPECT_EQ(rows.guard.counts().longest_gap_ns, 0);
  rows.push(27 * kMillisecond_ns);
  EXPECT_TRUE(rows.out.after_gap);
  EXPECT_EQ(rows.guard.counts().longest_gap_ns, 27 * kMillisecond_ns);
  EXPECT_EQ(rows.guard.counts().gaps, 1U);
}

TEST(Guard, TheAccelerometerLeadsOnlyWhereTheGyroscopeIsSilent) {
  Rows rows;
  for (int k = 0; k < 100; ++k) rows.push(10 * kMillisecond_ns);
  for (int k = 1; k <= 20; ++k) {
    rows.push(10 * kMillisecond_ns, 1, kAcc);
    // Four gaps of two and a half usual steps: 0.1 s.
    if (k <= 9) {
      EXPECT_FALSE(rows.out.leads) << k;
    } else if (k >= 12) {
      EXPECT_TRUE(rows.out.leads) << k;
    }
  }
  rows.push(10 * kMillisecond_ns);
  EXPECT_TRUE(rows.out.leads);
  rows.push(10 * kMillisecond_ns, 1, kAcc);
  EXPECT_FALSE(rows.out.leads) << "it speaks again";
}

TEST(Guard, TheAccelerometerWaitsAtTheStartForAGyroscopeThatBeginsLater) {
  Rows rows;
  for (int k = 0; k < 5; ++k) {
    rows.push(1 * kMillisecond_ns, 1, kAcc);
    EXPECT_FALSE(rows.out.leads) << k;
  }
  rows.push(-3 * kMillisecond_ns, 1, kGyr);  // the first block of another device: as old as the first one
  EXPECT_TRUE(rows.out.leads);
  EXPECT_EQ(rows.guard.counts().refused, 0U);
  EXPECT_EQ(rows.guard.counts().samples, 1U);
}

TEST(Guard, TheAccelerometerLeadsFromATenthOfASecondOnWhereNoGyroscopeBegins) {
  Rows rows;
  for (int k = 1; k <= 30; ++k) {
    rows.push(10 * kMillisecond_ns, 1, kAcc);
    EXPECT_EQ(rows.out.leads, k > 10) << k;
  }
}

/// At 1 kHz 40 ms are forty steps, and no longer than a machine may hold a block up.
TEST(Guard, AGyroscopeWhoseBlockIsHeldUpStillLeads) {
  Rows rows;
  for (int k = 0; k < 100; ++k) rows.push(1 * kMillisecond_ns);
  for (int k = 0; k < 40; ++k) {
    rows.push(1 * kMillisecond_ns, 1, kAcc);
    EXPECT_FALSE(rows.out.leads) << k;
  }
  rows.push(-39 * kMillisecond_ns, 1, kGyr);
  EXPECT_TRUE(rows.out.leads);
  EXPECT_EQ(rows.guard.counts().refused, 0U);
  for (int k = 0; k < 200; ++k) rows.push(1 * kMillisecond_ns, 1, kAcc);
  EXPECT_TRUE(rows.out.leads) << "this one is silent";
}

TEST(Guard, SaysWhichSensorsAreOverdueByTheirOwnStep) {
  Rows rows;
  for (int k = 1; k <= 200; ++k)
    rows.push(10 * kMillisecond_ns, 1, static_cast<std::uint8_t>(k % 5 == 0 ? kAcc | kGyr | kMag : kAcc | kGyr));
  EXPECT_EQ(rows.out.absent, kTemp);  // never heard
  for (int k = 1; k <= 12; ++k) rows.push(10 * kMillisecond_ns);
  EXPECT_EQ(rows.out.absent, kTemp) << "0.12 s after a magnetometer's reading each 0.05 s";
  for (int k = 1; k <= 2; ++k) rows.push(10 * kMillisecond_ns);
  EXPECT_EQ(rows.out.absent, kTemp | kMag);
}

TEST(Guard, ATemperatureHoldsUntilTheNextAndIsHandedOnOnce) {
  Rows rows;
  EXPECT_EQ(rows.push(10 * kMillisecond_ns, 1, kTemp), StageStatus::kDrop);
  EXPECT_TRUE(rows.guard.temp_known());
  rows.push(10 * kMillisecond_ns);
  EXPECT_TRUE(rows.out.sample.holds(kTemp)) << "it waited for a sample to join";
  EXPECT_EQ(rows.out.sample.temp_degC, 30.0);
  rows.push(10 * kMillisecond_ns);
  EXPECT_FALSE(rows.out.sample.holds(kTemp));
  EXPECT_EQ(rows.out.sample.temp_degC, 30.0);
  GuardedSample out;
  RawSample absurd{
      .t_ns = rows.t_ns + kMillisecond_ns, .sequence = rows.sequence + 1, .temp_degC = 600.0, .has = kGyr | kTemp};
  EXPECT_EQ(rows.guard.process(absurd, out), StageStatus::kDegraded);
  EXPECT_EQ(out.sample.temp_degC, 30.0);
  EXPECT_EQ(rows.guard.counts().not_finite, 1U);
}

}  // namespace
}  // namespace stillpoint::pipeline

/// Faults of the digital path: seen where they are, and in no clean reading.
#include "diagnosis/forensics/faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stillpoint::diag::detail {
namespace {

constexpr double kStep = 0.01;

/// A slow motion with white noise of two steps, on a lattice.
std::vector<Axis> readings(std::size_t rows, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 2.0 * kStep);
  std::vector<Axis> axes(3);
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t i = 0; i < rows; ++i)
      axes[a].y.push_back(
          kStep * std::round((5.0 * std::sin(0.01 * static_cast<double>(i * (a + 1))) + noise(random)) / kStep));
    axes[a].printed = kStep;
    axes[a].noise_sd = 2.0 * kStep;
  }
  return axes;
}

TEST(DigitalFaults, NoneInCleanReadings) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const auto axes = readings(6000, seed);
    EXPECT_TRUE(find_random_repeats(axes, {}).empty()) << seed;
    EXPECT_FALSE(find_bit_flips(axes[0])) << seed;
    EXPECT_FALSE(find_missing_codes(axes[0])) << seed;
  }
}

TEST(DigitalFaults, RowsThatOneSensorRepeatsAreFound) {
  auto axes = readings(6000, 1);
  for (std::size_t i = 50; i < 6000; i += 97 + i % 13)
    for (Axis& a : axes) a.y[i] = a.y[i - 1];
  const auto rows = find_random_repeats(axes, {});
  ASSERT_GT(rows.size(), 50U);
  EXPECT_EQ(rows.front(), 50U);
}

/// A line near half the rate beats with the rows: for some of them nothing moves, in any axis.
TEST(DigitalFaults, WhatALineBeatsToAStandstillIsNotRepeated) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.8 * kStep);
    std::vector<Axis> axes(3);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < 8000; ++i)
        axes[a].y.push_back(kStep * std::round(6.0 * std::sin(3.02 * static_cast<double>(i)) + noise(random) / kStep));
      axes[a].printed = kStep;
    }
    EXPECT_TRUE(find_random_repeats(axes, {}).empty()) << seed;
  }
}

/// On steps of five times the noise a body at rest repeats in every axis, also in the few rows before it turns again.
TEST(DigitalFaults, WhatRestsBetweenTurnsIsNotRepeated) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.2);
    std::vector<Axis> axes(3);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t i = 0; i < 6000; ++i) {
        const double turn = i % 97 < 67 ? 300.0 * std::sin(0.15 * static_cast<double>(i * (a + 1))) : 7.0;
        axes[a].y.push_back(kStep * std::round(turn + noise(random)));
      }
      axes[a].printed = kStep;
    }
    EXPECT_TRUE(find_random_repeats(axes, {}).empty()) << seed;
  }
}

TEST(DigitalFaults, AFlippedBitIsAPowerOfTwoInSteps) {
  auto axes = readings(6000, 2);
  int bit = 6;
  for (std::size_t i = 100; i < 6000; i += 300, bit = 6 + (bit + 1) % 4) axes[0].y[i] += kStep * std::exp2(bit);
  const auto flips = find_bit_flips(axes[0]);
  ASSERT_TRUE(flips);
  EXPECT_GE(flips->rows.size(), 18U);
  EXPECT_EQ(flips->lowest_bit, 6);
  EXPECT_EQ(flips->highest_bit, 9);
}

TEST(DigitalFaults, SinglePeaksOfAnySizeAreNoBits) {
  auto axes = readings(6000, 3);
  for (std::size_t i = 100; i < 6000; i += 300) axes[0].y[i] += 0.011 * static_cast<double>(i % 700) + 1.0;
  EXPECT_FALSE(find_bit_flips(axes[0]));
}

TEST(DigitalFaults, CodesThatNeverOccurAreMissing) {
  auto axes = readings(6000, 4);
  for (double& y : axes[0].y) {
    const auto code = std::llround(y / kStep) + 100000;
    if (code % 16 == 8) y += kStep;
  }
  const auto missing = find_missing_codes(axes[0]);
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->absent.size(), 1U);
}

TEST(DigitalFaults, ACoarserLatticeMissesNoCodes) {
  auto axes = readings(6000, 5);
  for (double& y : axes[0].y) y = 4.0 * kStep * std::round(y / (4.0 * kStep));
  EXPECT_FALSE(find_missing_codes(axes[0]));
}

}  // namespace
}  // namespace stillpoint::diag::detail

/// Which rows are rest, where the reference has a say.
#include "diagnosis/reference/rest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace stillpoint::diag {
namespace {

constexpr double kDt_s = 0.01;
constexpr Eigen::Index kRows = 1000, kBegin = 200, kEnd = 800;

Mask quiet() {
  Mask rest(kRows, 0);
  std::fill(rest.begin() + kBegin, rest.begin() + kEnd, std::uint8_t{1});
  return rest;
}

/// The rows of a rest that stay one beside a reference with this velocity along x, m/s.
Mask left_of(const Series& velocity_mps) {
  Series3 velocity = Series3::Zero(kRows, 3);
  velocity.col(0) = velocity_mps;
  Mask rest = quiet();
  wake_where_reference_moves(rest, Series3::Zero(kRows, 3), velocity, kDt_s, false);
  return rest;
}

TEST(Rest, ACarThatBrakesAndStandsIsAtRestWhenItStands) {
  Series v = Series::Zero(kRows);
  for (Eigen::Index i = 0; i < 400; ++i) v[i] = 0.02 * static_cast<double>(400 - i) / 4.0;  // stands from 4 s on
  const Mask rest = left_of(v);
  EXPECT_EQ(std::count(rest.begin() + kBegin, rest.begin() + 390, 1), 0);
  EXPECT_EQ(std::count(rest.begin() + 440, rest.begin() + kEnd, 1), kEnd - 440);
}

TEST(Rest, AFrameThatIsWrongIsNoMotion) {
  Series v = Series::Zero(kRows);
  v[500] = 2.0, v[501] = -2.0;  // 2 cm in one row
  EXPECT_EQ(left_of(v), quiet());
}

TEST(Rest, WhatMovesForMostOfItIsNoRest) {
  Series v = Series::Constant(kRows, 0.1);
  v.segment(700, 100).setZero();
  const Mask rest = left_of(v);
  EXPECT_EQ(std::count(rest.begin(), rest.end(), 1), 0);
}

/// A person stands: the camera's noise is larger than the sway, of which the gyroscope sees nothing else.
TEST(Rest, WhoSwaysUnderANoisyCameraIsNotAtRestAndATableIs) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const bool sways : {true, false}) {
    Signals s;
    s.n = kRows, s.dt_s = kDt_s;
    s.present[kGyr] = true;
    s.noise_sd[kGyr] = 1.5e-4;
    s.reading[kGyr] = Series3::Zero(kRows, 3);
    Series3 seen = Series3::Zero(kRows, 3), angle = Series3::Zero(kRows + 2, 3);
    for (Eigen::Index i = 0; i < angle.rows(); ++i)
      for (int axis = 0; axis < 3; ++axis) angle(i, axis) = 7e-4 * normal(random);
    for (Eigen::Index i = 0; i < kRows; ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const double sway = sways ? 4e-3 * std::sin(4.0 * kDt_s * static_cast<double>(i) + axis) : 0.0;
        seen(i, axis) = sway + (angle(i + 2, axis) - angle(i, axis)) / (2.0 * kDt_s);
        s.reading[kGyr](i, axis) = sway + 1.5e-4 * normal(random);
      }
    Mask rest = quiet();
    wake_where_both_move(rest, s, seen);
    EXPECT_EQ(std::count(rest.begin(), rest.end(), 1), sways ? 0 : kEnd - kBegin);
  }
}

/// Half a second in which the body turns by 20 mrad/s, as quiet as at rest: the camera sees that, and does not take a
/// wrong offset for it.
TEST(Rest, AShortStopThatTurnsIsNoneUnlessTheGyroscopeAloneSaysSo) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (const double camera : {0.02, 0.0}) {
    Signals s;
    s.n = kRows, s.dt_s = kDt_s;
    s.present[kGyr] = true;
    s.reading[kGyr] = Series3::Zero(kRows, 3);
    s.reading[kGyr].col(0).segment(500, 50).setConstant(0.02);
    Series3 seen = Series3::Zero(kRows, 3), angle = Series3::Zero(kRows + 2, 3);
    for (double& x : angle.reshaped()) x = 5e-4 * normal(random);
    for (Eigen::Index i = 0; i < kRows; ++i) seen.row(i) = (angle.row(i + 2) - angle.row(i)) / (2.0 * kDt_s);
    seen.col(0).segment(500, 50).array() += camera;
    Mask rest(kRows, 0);
    for (const auto& [begin, end] : {std::pair{100, 300}, std::pair{500, 550}})
      std::fill(rest.begin() + begin, rest.begin() + end, std::uint8_t{1});
    wake_where_both_turn(rest, s, seen, 5e-4);
    EXPECT_EQ(std::count(rest.begin(), rest.begin() + 400, 1), 200);
    EXPECT_EQ(std::count(rest.begin() + 400, rest.end(), 1), camera > 0 ? 0 : 50);
  }
}

}  // namespace
}  // namespace stillpoint::diag

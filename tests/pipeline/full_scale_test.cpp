/// Rails are found from plateaus, and from nothing else.
#include "pipeline/full_scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace stillpoint::pipeline {
namespace {

constexpr double kSmallest = 17.0;

/// Share of the samples marked of a run at 100 Hz with blows of `peak` on x, cut at `limit`.
double marked(double peak, double limit, double noise) {
  FullScale scale(kSmallest);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  int found = 0, samples = 0;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.01 * i;
    const double x = 9.8 + peak * std::pow(std::max(0.0, std::sin(8.0 * t)), 3) + noise * normal(random);
    found += scale.at_rail({std::min(x, limit), noise * normal(random), noise * normal(random)});
    ++samples;
  }
  return static_cast<double>(found) / samples;
}

TEST(FullScale, BlowsThatMeetTheRailAreMarked) {
  EXPECT_GT(marked(20.0, 19.6, 0.05), 0.15);
  EXPECT_GT(marked(60.0, 39.2, 0.05), 0.10);
}

TEST(FullScale, BlowsThatDoNotAreNot) { EXPECT_EQ(marked(20.0, 1e3, 0.05), 0.0); }

TEST(FullScale, RestSteadyTurnsAndHeldReadingsAreNoRail) {
  FullScale acc(kSmallest), gyr(2.0);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 3000; ++i) {
    const double flicker = i % 7 == 0 ? 0.01 : 0.0;  // a coarse lattice at rest
    EXPECT_FALSE(acc.at_rail({flicker, 0.0, 9.81}));
    // A turntable, and a source that repeats each reading three times.
    static Array3 held{};
    if (i % 3 == 0) held = {0.01 * normal(random), 0.01 * normal(random), 3.0 + 0.01 * normal(random)};
    EXPECT_FALSE(gyr.at_rail(held));
  }
}

/// A gyroscope of 60 deg/s: less than most are sold with.
TEST(FullScale, ASmallRailIsTakenForOneWhereTheLatticeIsFine) {
  for (const double lattice : {1e-6, 0.02}) {
    FullScale gyr(2.0);
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    int marked = 0;
    for (int i = 0; i < 3000; ++i) {
      const double cut = std::min(1.5 * std::sin(0.05 * i) + 0.003 * normal(random), lattice < 0.01 ? 1.047 : 10.0);
      marked += gyr.at_rail({lattice * std::round(cut / lattice), normal(random), normal(random)});
    }
    if (lattice < 0.01)
      EXPECT_GT(marked, 600);
    else
      EXPECT_EQ(marked, 0) << "the turn of a swing on a coarse lattice";
  }
}

/// A driver that filters, scales or turns readings leaves the last bits of each different.
TEST(FullScale, RoundingIsNoLattice) {
  FullScale gyr(2.0);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 3000; ++i) {
    Array3 reading{};  // at rest: noise of a lattice step
    for (double& x : reading) x = 0.001 * std::round(normal(random)) + (i % 3 == 0 ? 1e-16 * normal(random) : 0.0);
    EXPECT_FALSE(gyr.at_rail(reading)) << i;
  }
}

TEST(FullScale, AReadingBeyondARailTakesItBack) {
  FullScale scale(kSmallest);
  double other = 0.0;
  bool any = false;
  for (int blow = 0; blow < 5; ++blow)
    for (const double x : {9.8, 15.0, 18.0, 18.0, 18.0, 9.8}) any |= scale.at_rail({x, other += 0.1, 0.0});
  EXPECT_TRUE(any);
  EXPECT_FALSE(scale.at_rail({25.0, other += 0.1, 0.0}));
  EXPECT_FALSE(scale.at_rail({18.0, other += 0.1, 0.0}));
}

}  // namespace
}  // namespace stillpoint::pipeline

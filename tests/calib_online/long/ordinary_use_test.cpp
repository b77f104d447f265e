/// Ordinary use over forty seeds each: the figures of docs/calibration_figures.md.
#include <gtest/gtest.h>

#include "bench/ordinary_use.h"

namespace stillpoint::bench {
namespace {

/// 98 %, less the scatter of 80 draws: 3 outside of 80 are still within its 95 %.
constexpr double kLeast_percent = 96.2;

TEST(OrdinaryUse, LiesInsideThreeStatedDeviationsInNinetyEightPercent) {
  for (const UseCase& use : use_cases())
    for (const auto& [quantity, s] : score(use, 0, 40))
      EXPECT_GE(s.inside_percent, kLeast_percent) << use.name << ", " << quantity;
}

TEST(OrdinaryUse, IsStatedNoMoreThanThreeTimesTooWideInFortySeeds) {
  for (const auto& [quantity, s] : score(use_cases().front(), 0, 40)) EXPECT_LT(s.stated, 3.0 * s.error) << quantity;
}

}  // namespace
}  // namespace stillpoint::bench

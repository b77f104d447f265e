#include "core/directions.h"

#include <gtest/gtest.h>

#include <numbers>

namespace stillpoint {
namespace {

TEST(Directions, TheTurnBetweenTwoIsTheShortestAndEndsAtTheSecond) {
  const Vec3 all[] = {{1, 0, 0}, {0, -3, 4}, {0.2, -0.1, 9.8}, {-1, 1e-9, 0}, {-1e-3, 2e-3, -5e-3}};
  for (const Vec3& from : all)
    for (const Vec3& to : all) {
      const Quat turn = turn_between(from, to);
      EXPECT_NEAR(turn.norm(), 1.0, 1e-12);
      EXPECT_NEAR(angle_rad(turn * from, to), 0.0, 1e-8);
      EXPECT_NEAR(2.0 * std::acos(std::min(1.0, std::abs(turn.w()))), angle_rad(from, to), 1e-7);
    }
}

TEST(Directions, OppositeOnesAreTurnedAboutAnAxisAcross) {
  for (const Vec3& from : {Vec3(0, 0, 2), Vec3(1, 0, 0), Vec3(-3, 4, 12)}) {
    const Quat turn = turn_between(from, -0.5 * from);
    EXPECT_NEAR((turn * from + from).norm(), 0.0, 1e-12 * from.norm());
    EXPECT_NEAR(turn.vec().dot(from), 0.0, 1e-12 * from.norm());
  }
}

}  // namespace
}  // namespace stillpoint

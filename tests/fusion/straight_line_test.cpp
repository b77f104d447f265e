/// Rates that were drawn as lines between two readings are told from those of a sensor.
#include "fusion/straight_line.h"

#include <gtest/gtest.h>

#include <random>

namespace stillpoint::fusion {
namespace {

constexpr double kRise_radps2 = 0.5;

/// After so many rows of one line.
bool drawn_after(int rows, double rate_hz, double noise_radps = 0.0) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, 1.0);
  StraightLine line;
  line.note({0.0, 9.0, 0.0}, 1.0 / rate_hz);  // something else before
  for (int k = 0; k < rows; ++k)
    line.note({kRise_radps2 * k / rate_hz + noise_radps * normal(random), 1.0, -0.3}, 1.0 / rate_hz);
  return line.drawn();
}

TEST(StraightLine, IsSeenAfterEightRowsOfItAndATenthOfASecond) {
  // Its first row ends what was before; the line stands between that one and the present.
  EXPECT_FALSE(drawn_after(8, 50.0));
  EXPECT_TRUE(drawn_after(9, 50.0));
  EXPECT_FALSE(drawn_after(9, 200.0)) << "0.05 s of it";
  EXPECT_TRUE(drawn_after(30, 200.0));
}

TEST(StraightLine, ASensorsNoiseDrawsNone) { EXPECT_FALSE(drawn_after(60, 50.0, 1e-3)); }

}  // namespace
}  // namespace stillpoint::fusion

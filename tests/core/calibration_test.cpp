#include "core/calibration.h"

#include <gtest/gtest.h>

namespace stillpoint {
namespace {

TriadCalibration warm_sensor() {
  TriadCalibration c;
  c.matrix = {2, 0, 0, 0, 1, 0.5, 0, 0, 1};
  c.bias = {1, 2, 3};
  c.bias_per_K = {0.1, 0, 0};
  c.bias_per_K2 = {0, 0.01, 0};
  c.temp_ref_degC = 20;
  c.temp_min_degC = 10;
  c.temp_max_degC = 40;
  return c;
}

TEST(TriadCalibration, SubtractsTheBiasOfItsTemperatureThenAppliesTheMatrix) {
  // At 30 degC tau is 10 K: B = (1 + 1, 2 + 1, 3); u = H (y - B) with y - B = (1, 1, 4).
  EXPECT_LT((warm_sensor().apply({3, 4, 7}, 30.0) - Vec3(2, 3, 4)).norm(), 1e-14);
}

TEST(TriadCalibration, NeverExtrapolatesBeyondTheTemperaturesSeen) {
  const TriadCalibration c = warm_sensor();
  EXPECT_EQ(c.bias_at(90.0), c.bias_at(40.0));
  EXPECT_EQ(c.bias_at(-50.0), c.bias_at(10.0));
  EXPECT_NE(c.bias_at(39.0), c.bias_at(40.0));
}

TEST(TriadCalibration, LeavesReadingsAloneBeforeAnythingIsKnown) {
  EXPECT_EQ(TriadCalibration{}.apply({3, 4, 7}, 70.0), Vec3(3, 4, 7));
}

}  // namespace
}  // namespace stillpoint

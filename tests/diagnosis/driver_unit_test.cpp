#include "diagnosis/reference/driver_unit.h"

#include <gtest/gtest.h>

namespace stillpoint::diag {
namespace {

TEST(DriverUnit, IsTheReadingsPerThatOfEveryFactor) {
  EXPECT_EQ(coefficient_unit("rad/s", "(T-T0)"), "rad/s per K");
  EXPECT_EQ(coefficient_unit("rad/s", "f_z*(T-T0)"), "rad/s per m/s^2 K");
  EXPECT_EQ(coefficient_unit("uT", "I*I"), "uT per A A");
  EXPECT_EQ(coefficient_unit("m/s^2", "|w|*(V-V0)"), "m/s^2 per rad/s V");
  EXPECT_EQ(coefficient_unit("rad/s", "w^3"), "rad/s per (rad/s)^3");
  EXPECT_EQ(coefficient_unit("uT", "|m_i|"), "uT per uT");
  EXPECT_EQ(coefficient_unit("uT", "dw/dt*|f|"), "uT per rad/s^2 m/s^2");
}

TEST(DriverUnit, OfWhatIsNoProductIsThatOfItsParameters) {
  EXPECT_EQ(coefficient_unit("uT", "offset(t)"), "uT");
  EXPECT_EQ(coefficient_unit("uT", "m(t)"), "1");
  EXPECT_EQ(coefficient_unit("uT", "field(p)"), "uT/m");
  EXPECT_EQ(coefficient_unit("m/s^2", "dw/dt x r + w x (w x r)"), "m");
}

}  // namespace
}  // namespace stillpoint::diag

/// Ordinary use, case by case, over a few seeds: what is published lies inside three of its stated deviations. Forty
/// seeds: tests/calib_online/long.
#include <gtest/gtest.h>

#include "bench/ordinary_use.h"

namespace stillpoint::bench {
namespace {

class OrdinaryUseCase : public ::testing::TestWithParam<UseCase> {};

TEST_P(OrdinaryUseCase, IsLearntWithinWhatIsStated) {
  for (const auto& [quantity, s] : score(GetParam(), 0, 3)) {
    EXPECT_GE(s.inside_percent, 98.0) << GetParam().name << ", " << quantity;
    EXPECT_EQ(s.stated_at_all, s.judged) << GetParam().name << ", " << quantity << ": nothing stated";
  }
}

/// At the end of each story the sensor is known again: half a percent, 10 mg, 0.05 deg/s.
TEST_P(OrdinaryUseCase, LeavesAKnownSensor) {
  const auto scores = score(GetParam(), 0, 3);
  EXPECT_LT(scores.at("acc norm, m/s2").error, 0.1) << GetParam().name;
  EXPECT_LT(scores.at("gyr bias, deg/s").error, 0.05) << GetParam().name;
  EXPECT_LT(scores.at("gyr matrix").error, 0.005) << GetParam().name;
}

INSTANTIATE_TEST_SUITE_P(Case, OrdinaryUseCase, ::testing::ValuesIn(use_cases()), [](const auto& use) {
  std::string name;
  for (const char* c = use.param.name; *c != '\0'; ++c) name += std::isalnum(static_cast<unsigned char>(*c)) ? *c : '_';
  return name;
});

}  // namespace
}  // namespace stillpoint::bench

/// What a law removes on a recording that it was not made from.
#include "diagnosis/validation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

const test::Parameters kArm{{"r_m", {0.1, 0.0, 0.05}}};

Validation of(const std::string& sensor, const std::vector<Validation>& all) {
  for (const Validation& v : all)
    if (v.sensor == sensor) return v;
  return {};
}

TEST(Validate, TheTrueLawTakesAllAndTheWrongOneDoesHarm) {
  const auto config = test::baseline("exact", 60.0);
  const io::Recording other = test::record(config, "acc_lever", kArm, 8);
  auto improved = config;
  improved.effects.push_back({.id = "acc_lever", .parameters = kArm, .axes = {}, .window_s = {}});
  const auto right = validate("other.csv", other, config, improved);
  EXPECT_NEAR(of("acc", right).share, 1.0, 0.02);
  EXPECT_LT(of("acc", right).ci95[0], of("acc", right).share);
  EXPECT_FALSE(std::isfinite(of("gyr", right).share)) << "nothing of the gyroscope was left out";
  improved.effects.back().parameters = {{"r_m", {-0.1, 0.0, -0.05}}};
  const Validation wrong = of("acc", validate("other.csv", other, config, improved));
  EXPECT_LT(wrong.ci95[1], 0.0);
  EXPECT_GT(wrong.rms_after, wrong.rms_before);
}

TEST(Validate, SaysNothingWithoutAReference) {
  const auto config = test::baseline("none", 30.0);
  EXPECT_TRUE(validate("other.csv", test::record(config, "", {}, 2), config, config).empty());
}

}  // namespace
}  // namespace stillpoint::diag

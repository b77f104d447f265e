/// What a reference shows beyond the highest reading is a rail's doing, unless it scatters as much by itself.
#include "diagnosis/reference/hidden_rail.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

constexpr double kRail_mps2 = 16.0, kTop_mps2 = 40.0;

/// An accelerometer of noise behind its rail, beside a reference with an error.
Signals strides(double reference_sd) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  Signals s;
  s.n = 4000;
  Series3 truth = Series3::Zero(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    truth(i, 0) = kTop_mps2 * std::pow(std::sin(0.02 * static_cast<double>(i)), 9.0);
    truth(i, 1) = 9.8 * std::cos(0.013 * static_cast<double>(i));
  }
  const auto with_noise = [&](const Series3& x, double sd) -> Series3 {
    return x.unaryExpr([&](double v) { return v + sd * noise(random); });
  };
  s.reading[kAcc] = with_noise(truth.cwiseMax(-kRail_mps2).cwiseMin(kRail_mps2), 0.01);
  s.predicted[kAcc] = with_noise(truth, reference_sd);
  s.vector[kAcc] = s.reading[kAcc];
  s.muted[kAcc].assign(static_cast<std::size_t>(s.n), 0);
  return s;
}

TEST(HiddenRail, IsLookedForJustBelowTheHighestReading) {
  const HiddenRail rail = hidden_rail(strides(0.05), kAcc);
  EXPECT_GT(rail.clipped.maxCoeff(), 39.0) << "the reference shows what is missing";
  EXPECT_LT(rail.levels[0], kRail_mps2);
  EXPECT_NEAR(rail.levels[1], kRail_mps2, 0.1);
  EXPECT_TRUE(std::ranges::is_sorted(rail.levels));
}

TEST(HiddenRail, IsNotLookedForBesideAReferenceThatScattersAsMuch) {
  const Signals s = strides(4.0);
  EXPECT_EQ(hidden_rail(s, kAcc).clipped, s.reading[kAcc]);
}

/// Below the strongest strides, beside an exact reference and one that is only good.
TEST(HiddenRail, IsNamedWithItsLevel) {
  for (const std::string reference : {"exact", "mocap"}) {
    auto config = test::baseline(reference, 60.0);
    config.reference.orientation_sd_rad = 3e-4, config.reference.position_sd_m = 5e-5, config.reference.band_hz = 5.0;
    config.rate_hz = 100;
    config.motion->kind = "walking";
    const Answer clean = diagnose(test::record(config, "", {}, 3), config);
    ASSERT_THAT(test::names(clean), testing::IsEmpty());
    const Answer answer =
        diagnose(test::record(config, "acc_sat", {{"L_mps2", {12.0, 12.0, 12.0}}, {"hidden", {1}}}, 3), config);
    ASSERT_THAT(test::names(answer), testing::ElementsAre("acc_sat"));
    EXPECT_NEAR(answer.diagnosis.findings.front().parameters.front().value, 12.0, 0.3);
  }
}

}  // namespace
}  // namespace stillpoint::diag

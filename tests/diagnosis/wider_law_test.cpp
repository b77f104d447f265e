// A law that only has more terms than the stated one is no rival: the recording bounds its terms.
#include <gmock/gmock.h>

#include "diagnosis/summary.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

TEST(WiderLaw, TheSquareBesideALineInTemperatureIsBounded) {
  const std::vector<double> k2{1e-5, -1e-5, 2e-5};  // of 9 K at most a twentieth of the noise of one sample
  auto config = test::baseline("exact");
  config.environment.temperature = {.kind = "warm_up", .start_degC = 24.0, .rise_K = 10.0, .tau_s = 60.0};
  int inside = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const auto recording =
        test::record(config, "acc_temp_quad", {{"k1_mps2_per_K", {2e-3, -1.5e-3, 3e-3}}, {"k2_mps2_per_K2", k2}}, seed);
    const Diagnosis d = diagnose(recording, config).diagnosis;
    ASSERT_THAT(test::names(d), testing::ElementsAre("acc_temp_lin")) << seed;
    const Finding& f = d.findings.front();
    ASSERT_TRUE(f.wider) << seed;
    EXPECT_EQ(f.wider->effect, "acc_temp_quad");
    ASSERT_EQ(f.wider->further.size(), 3U);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Parameter& p = f.wider->further[axis];
      EXPECT_EQ(p.unit, "m/s^2/K^2");
      EXPECT_LT(p.ci95[1] - p.ci95[0], 1e-3) << "not bounded at all";
      inside += p.ci95[0] <= k2[axis] && k2[axis] <= p.ci95[1];
    }
    EXPECT_THAT(to_text(d), testing::Not(testing::HasSubstr("or acc_temp_quad in")));
    EXPECT_THAT(to_text(d), testing::HasSubstr("BOUNDS   terms that acc_temp_quad has beside these"));
  }
  EXPECT_GE(inside, 10) << "of 12 intervals of 95 %";
}

}  // namespace
}  // namespace stillpoint::diag

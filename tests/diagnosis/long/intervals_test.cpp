// 95 % intervals hold the truth in 95 % of the cases, of slow laws and of steps as of laws of the motion.
#include <gmock/gmock.h>

#include <cstdio>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::baseline;
using test::record;

struct Covered {
  int inside = 0, all = 0;
};

/// Adds the numbers of the finding with this name, in the order of its parameters.
void count(const Answer& answer, const std::string& id, const std::vector<double>& truth, Covered& c) {
  for (const Finding& f : answer.diagnosis.findings)
    for (std::size_t i = 0; f.effect == id && i < truth.size() && i < f.parameters.size(); ++i) {
      const auto& [low, high] = f.parameters[i].ci95;
      ++c.all;
      c.inside += low <= truth[i] && truth[i] <= high;
    }
}

class Intervals : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Diagnosis, Intervals, testing::Values("exact", "mocap"));

TEST_P(Intervals, HoldTheTruthInNineteenOfTwentyCases) {
  const std::vector<double> thermal{4e-4, -3e-4, 5e-4}, quad{2e-3, -1.5e-3, 1e-3},
      soft{0.006, 0.002, -0.003, 0.001, -0.007, 0.004, 0.003, 0.0, 0.006};
  Covered c;
  for (std::uint64_t seed = 500; seed < 530; ++seed) {
    auto config = baseline(GetParam(), 60.0);
    config.environment.temperature = {.kind = "warm_up", .rise_K = 10.0, .tau_s = 40.0};
    auto physics = config;
    physics.effects = {
        {.id = "gyr_temp_lin", .parameters = {{"k_radps_per_K", thermal}}, .axes = {}, .window_s = {}},
        {.id = "acc_quad", .parameters = {{"k2_per_mps2", quad}}, .axes = {}, .window_s = {}},
        {.id = "mag_soft_step", .parameters = {{"M", soft}, {"t0_s", {30.0}}}, .axes = {}, .window_s = {}}};
    const Answer answer = diagnose(record(physics, "", {}, seed), config);
    count(answer, "gyr_temp_lin", thermal, c);
    count(answer, "acc_quad", quad, c);
    count(answer, "mag_soft_step", soft, c);
  }
  std::printf("%d of %d numbers inside\n", c.inside, c.all);
  EXPECT_GE(c.all, 400);
  EXPECT_GT(c.inside, 0.92 * c.all);
  EXPECT_LT(c.inside, 0.99 * c.all);  // robust deviations are wide where the errors are what was assumed
}

}  // namespace
}  // namespace stillpoint::diag

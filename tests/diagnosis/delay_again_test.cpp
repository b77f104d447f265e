/// A delay found as such is not found again as a law of the rate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnosis/diagnose.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

/// As BROAD's export has it: each row a mean of its neighbours, so that no delay is the whole of it. With d(w) beside
/// it a delay of 4 ms had become a filter of 6 ms, of which d(w) took back 2.
TEST(ADelayAndItsRate, DoNotUndoEachOther) {
  sim::SimulationConfig config = test::baseline("exact", 60.0);
  config.rate_hz = 100.0;
  config.motion->rate_radps = 3.0;
  io::Recording recording = test::record(config, "gyr_delay", {{"tau_s", {0.004}}}, 1);
  const std::vector<Vec3> read = recording.gyr_radps;
  for (std::size_t i = 1; i + 1 < read.size(); ++i)
    recording.gyr_radps[i] = 0.25 * read[i - 1] + 0.5 * read[i] + 0.25 * read[i + 1];
  const Answer answer = diagnose(recording, config);
  ASSERT_FALSE(answer.diagnosis.findings.empty());
  for (const Finding& f : answer.diagnosis.findings) EXPECT_FALSE(f.effect.starts_with("unknown:d(w)")) << f.effect;
  const Finding& late = answer.diagnosis.findings.front();
  ASSERT_THAT(late.effect, testing::AnyOf("gyr_delay", "gyr_lpf"));
  EXPECT_NEAR(late.parameters.front().value, 0.004, 0.0003);
}

}  // namespace
}  // namespace stillpoint::diag

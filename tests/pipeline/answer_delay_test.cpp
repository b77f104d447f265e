/// What was learnt takes effect a fixed delay after its evidence, however much evidence follows.
#include <gtest/gtest.h>

#include "core/units.h"
#include "pipeline/stages.h"
#include "tests/pipeline/samples.h"

namespace stillpoint::pipeline {
namespace {

/// Time of the first sample corrected by anything learnt, s; the duration if there was none.
double first_used_s(double answer_delay_s) {
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  StagesParams params;
  params.answer_delay_s = answer_delay_s;
  Stages stages(params, calibrator.snapshot());
  Processed out;
  const auto samples = test::hand_samples(90.0);
  for (const RawSample& sample : samples) {
    stages.process(sample, out, link);
    if (stages.live().version > 0) return in_seconds(sample.t_ns - samples.front().t_ns);
  }
  return 90.0;
}

TEST(AnswerDelay, IsADelayAndNothingMore) {
  const double base_s = first_used_s(0.0);
  ASSERT_LT(base_s, 30.0) << "nothing was learnt: the test would prove nothing";
  for (const double delay_s : {0.5, 1.0, 1.9, 5.0})
    EXPECT_NEAR(first_used_s(delay_s), base_s + delay_s, 0.05) << delay_s;
}

TEST(AnswerSchedule, GivesTheNewestThatIsDueAndNeverMoreThanThatOnce) {
  AnswerSchedule schedule;
  EXPECT_FALSE(schedule.due(0).has_value());
  for (const std::int64_t due : {10, 20, 30}) schedule.submitted(due);
  EXPECT_FALSE(schedule.due(9).has_value());
  EXPECT_EQ(schedule.due(25), 2U);
  schedule.taken(2);
  EXPECT_FALSE(schedule.due(25).has_value());
  EXPECT_EQ(schedule.due(30), 3U);
  for (std::size_t k = 0; k < kMostOnTheWay - 1; ++k) schedule.submitted(100);
  EXPECT_TRUE(schedule.full());
}

}  // namespace
}  // namespace stillpoint::pipeline

/// A program of its own, because it replaces malloc. Without sanitizers, which replace it as well.
#include "bench/allocations.h"

#include <gtest/gtest.h>

#include <memory>

#include "pipeline/sensor_loop.h"
#include "tests/pipeline/samples.h"

namespace stillpoint::pipeline {
namespace {

TEST(Allocations, CounterSeesMallocItself) {
  const std::size_t before = bench::allocations();
  void* volatile memory = std::malloc(64);
  std::free(memory);
  EXPECT_EQ(bench::allocations() - before, 1U);
}

TEST(Allocations, TenThousandSamplesThroughTheSensorThreadsStagesMakeNone) {
  const auto samples = test::hand_samples(125.0);
  const auto shared = std::make_unique<Shared>();
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages(StagesParams{}, calibrator.snapshot());
  const auto processed = std::make_unique<Processed>();
  const auto out = std::make_unique<Outgoing>();
  constexpr std::size_t kWarmUp = 2000, kCounted = 10'000;
  ASSERT_GE(samples.size(), kWarmUp + kCounted);
  std::size_t before = 0;
  std::uint64_t windows_before = 0;
  for (std::size_t i = 0; i < kWarmUp + kCounted; ++i) {
    if (i == kWarmUp) {
      before = bench::allocations();
      windows_before = stages.counts().windows;
    }
    ASSERT_NE(stages.process(samples[i], *processed, link), StageStatus::kDrop);
    out->message = to_message(*processed, false);
    shared->outgoing.try_push(*out);
    if (i % 100 == 0) shared->outgoing.try_pop(*out);
    shared->latency.add(static_cast<std::int64_t>(i));
  }
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_GT(stages.counts().windows, windows_before) << "no window was found: the count would not cover them";
}

TEST(Allocations, ARehearsalMakesNone) {
  const auto samples = test::hand_samples(2.0);
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages(StagesParams{}, calibrator.snapshot());
  Processed processed;
  Rehearsal rehearsal(stages, 90e-6);
  const std::int64_t start_ns = monotonic_ns();
  const std::size_t before = bench::allocations();
  for (std::size_t i = 0; i < 100; ++i) {
    ASSERT_NE(stages.process(samples[i], processed, link), StageStatus::kDrop);
    rehearsal.before_next(stages, samples[i], start_ns + static_cast<std::int64_t>(i) * 1'000'000);
  }
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_GT(rehearsal.count(), 10U);
}

}  // namespace
}  // namespace stillpoint::pipeline

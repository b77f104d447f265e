/// Whatever the sensor, the bus or the clock does, nothing invalid leaves the stages and time goes forward.
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/fault_injector.h"
#include "pipeline/sources.h"
#include "pipeline/stages.h"
#include "tests/pipeline/samples.h"

namespace stillpoint::pipeline {
namespace {

struct Outcome {
  std::size_t published = 0, invalid = 0, backward = 0;
  GuardCounts guard;
  StagesCounts stages;
};

bool valid(const AttitudeMessage& m) {
  double norm2 = 0.0;
  for (const double x : m.q_world_body_xyzw) norm2 += x * x;
  bool finite = std::abs(norm2 - 1.0) < 1e-6;
  for (const double x : m.rate_radps) finite = finite && std::isfinite(x);
  for (const double x : m.orientation_covariance_rad2) finite = finite && std::isfinite(x);
  for (const double x : m.sigma_rpy_rad) finite = finite && std::isfinite(x) && x >= 0.0;
  return finite;
}

Outcome run(const FaultParams& faults, double seconds = 60.0) {
  FaultInjector<MemorySource> source(MemorySource(test::hand_samples(seconds)), faults);
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages(StagesParams{}, calibrator.snapshot());
  Outcome outcome;
  Arrival arrival;
  Processed processed;
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  while (source.next(arrival) == SourceState::kSample) {
    if (stages.process(arrival.sample, processed, link) == StageStatus::kDrop) continue;
    const AttitudeMessage m = to_message(processed);
    ++outcome.published;
    outcome.invalid += valid(m) ? 0U : 1U;
    outcome.backward += m.t_ns > last_ns ? 0U : 1U;
    last_ns = m.t_ns;
  }
  outcome.guard = stages.guard().counts();
  outcome.stages = stages.counts();
  return outcome;
}

void expect_sound(const Outcome& o) {
  EXPECT_EQ(o.invalid, 0U);
  EXPECT_EQ(o.backward, 0U);
  EXPECT_GT(o.published, 1000U);
}

TEST(Faults, NoneAreFoundInASoundStream) {
  const Outcome o = run({});
  expect_sound(o);
  EXPECT_EQ(o.guard.refused + o.guard.not_finite + o.guard.gaps + o.guard.clock_steps, 0U);
  EXPECT_EQ(o.published, o.guard.samples);
  EXPECT_GT(o.stages.windows, 2U);
}

TEST(Faults, LostSamplesAreCountedAsGaps) {
  const Outcome o = run({.drop = 0.05});
  expect_sound(o);
  EXPECT_GT(o.guard.lost, 200U);
  EXPECT_GT(o.guard.gaps, 150U);
}

TEST(Faults, ARepeatedSampleIsRefusedAndNeverPublishedTwice) {
  const Outcome o = run({.duplicate = 0.1});
  expect_sound(o);
  EXPECT_GT(o.guard.refused, 400U);
  EXPECT_EQ(o.published + o.guard.refused, o.guard.samples);
}

TEST(Faults, NotANumberIsTakenOutAndCounted) {
  const Outcome o = run({.not_finite = 0.1});
  expect_sound(o);
  EXPECT_GT(o.guard.not_finite, 400U);
}

TEST(Faults, BrokenTransfersUpToTenToTheThreeHundredDoNoHarm) { expect_sound(run({.garbage = 0.05})); }

TEST(Faults, APauseIsBridged) {
  const Outcome o = run({.stall = 0.002, .stall_s = 3.0});
  expect_sound(o);
  EXPECT_GE(o.guard.longest_gap_ns, 2'900'000'000);
}

TEST(Faults, AClockSetBackOrFarForwardIsFollowed) {
  for (const double step_s : {-0.5, -10.0, -1e6, 5.0, 1e6}) {
    const Outcome o = run({.clock_step = 0.001, .clock_step_s = step_s});
    expect_sound(o);
    EXPECT_GT(o.published, o.guard.samples * 9 / 10) << "after a step of " << step_s << " s the stream must go on";
    if (step_s != 5.0) {
      EXPECT_GT(o.guard.clock_steps, 0U) << step_s;  // a step of 5 s forward is a pause for all we know
    }
  }
}

TEST(Faults, TimesAtTheEndsOfWhatAClockCanCountDoNoHarm) {
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max(), kFar = 4'000'000'000'000'000'000;
  GuardStage guard;
  GuardedSample out;
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  std::size_t passed = 0;
  for (const std::int64_t base : {-kLargest - 1, -kFar, kFar - 1000, kLargest - 1000, -kFar, std::int64_t{0}})
    for (std::int64_t k = 0; k < 20; ++k) {
      const RawSample in{.t_ns = base + 10 * k, .acc_mps2 = {0, 0, 9.8}, .has = kAcc | kGyr};
      if (guard.process(in, out) == StageStatus::kDrop) continue;
      ++passed;
      EXPECT_GT(out.sample.t_ns, last_ns);
      last_ns = out.sample.t_ns;
    }
  EXPECT_GE(passed, 20U + 20U + 13U + 20U) << "a time within 126 years is followed wherever the clock was before";
  expect_sound(run({.clock_step = 0.01, .clock_step_s = 1e9}));
  expect_sound(run({.clock_step = 0.01, .clock_step_s = -1e9}));
}

TEST(Faults, ASourceSlowerThanTheMachineLivesIsSlept) {
  PacedSource<MemorySource> source(MemorySource({{.t_ns = 0, .has = kAcc}, {.t_ns = 1'000'000'000, .has = kAcc}}),
                                   1e-300);
  Arrival out;
  EXPECT_EQ(source.next(out), SourceState::kSample);
  EXPECT_EQ(source.next(out), SourceState::kNothing);
}

TEST(Faults, WhatIsDrawnAheadIsToldOnceAndInOrder) {
  using enum SourceState;
  struct Scripted {
    int* drawn;
    SourceState next(Arrival& out) noexcept {
      static constexpr SourceState kScript[] = {kSample, kSample, kGone, kSample, kEnd};
      out.sample = {.t_ns = 1000 * *drawn, .has = kAcc};
      return kScript[std::min((*drawn)++, 4)];
    }
  };
  int drawn = 0;
  FaultInjector<PacedSource<Scripted>> source(PacedSource<Scripted>({&drawn}, 1.0), {});
  Arrival out;
  int told = 0;
  for (const SourceState expected : {kSample, kSample, kGone, kSample, kEnd, kEnd}) {
    EXPECT_EQ(source.next(out), expected) << told;
    if (expected == kSample) {
      EXPECT_EQ(out.sample.t_ns, 1000 * told);
    }
    EXPECT_EQ(drawn, ++told);
    prepare(source);
    prepare(source);
    EXPECT_EQ(drawn, told + 1) << "drawn while nothing waits, and no further";
  }
}

TEST(Faults, SaturationIsMarked) {
  GuardStage guard({.gyr_limit_radps = 10.0});
  GuardedSample out;
  RawSample in{.t_ns = 1, .acc_mps2 = {0, 0, 9.8}, .gyr_radps = {0, -10.0, 0}, .has = kAcc | kGyr};
  EXPECT_EQ(guard.process(in, out), StageStatus::kDegraded);
  EXPECT_EQ(out.clipped, kGyr);
}

TEST(Faults, AllAtOnceWithManySeedsLetNothingInvalidOut) {
  for (int seed = 1; seed <= 10; ++seed) {
    const Outcome o = run({.drop = 0.02,
                           .duplicate = 0.02,
                           .not_finite = 0.02,
                           .saturate = 0.02,
                           .stall = 0.0005,
                           .clock_step = 0.0005,
                           .garbage = 0.02,
                           .seed = seed},
                          30.0);
    EXPECT_EQ(o.invalid, 0U) << seed;
    EXPECT_EQ(o.backward, 0U) << seed;
    EXPECT_GT(o.published, 500U) << seed;
  }
}

}  // namespace
}  // namespace stillpoint::pipeline

/// A program of its own, because it replaces malloc. Without sanitizers, which replace it as well.
#include "bench/allocations.h"

#include <gtest/gtest.h>

#include <memory>

#include "c_api/stillpoint.h"
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
    out->message = to_message(*processed);
    shared->outgoing.try_push(*out);
    if (i % 100 == 0) shared->outgoing.try_pop(*out);
    shared->latency.add(static_cast<std::int64_t>(i));
  }
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_GT(stages.counts().windows, windows_before) << "no window was found: the count would not cover them";
}

TEST(Allocations, TheCInterfaceMakesNoneAfterCreation) {
  const auto samples = test::hand_samples(60.0);
  stillpoint_imu* const imu = stillpoint_create(nullptr, 0, nullptr, 0);
  stillpoint_attitude attitude;
  stillpoint_calibration calibration;
  const std::size_t before = bench::allocations();
  for (const RawSample& s : samples) {
    stillpoint_reading r{s.t_ns, {}, {}, {}, s.temp_degC, s.has};
    std::copy(s.acc_mps2.begin(), s.acc_mps2.end(), r.acc_mps2);
    std::copy(s.gyr_radps.begin(), s.gyr_radps.end(), r.gyr_radps);
    std::copy(s.mag_uT.begin(), s.mag_uT.end(), r.mag_uT);
    ASSERT_EQ(stillpoint_push(imu, &r), STILLPOINT_DONE);
    stillpoint_get_attitude(imu, s.t_ns, &attitude, sizeof attitude);
  }
  stillpoint_get_calibration(imu, STILLPOINT_ACC, &calibration, sizeof calibration);
  stillpoint_set_calibration(imu, STILLPOINT_ACC, &calibration, sizeof calibration);
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_GT(attitude.calibration_version, 0U);
  stillpoint_destroy(imu);
}

TEST(Allocations, ARehearsalMakesNone) {
  const auto samples = test::hand_samples(2.0);
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  StagesParams params;
  const TakenOutLaw law{&Momentary::rate,
                        [m = Mat3(1e-3 * Mat3::Identity())](const Momentary& now) -> Vec3 { return m * now.force; }};
  params.compensation.laws = std::make_shared<const std::vector<TakenOutLaw>>(3, law);
  params.compensation.any = true;
  Stages stages(params, calibrator.snapshot());
  Processed processed;
  Rehearsal rehearsal(stages, 90e-6);
  const std::int64_t start_ns = monotonic_ns();
  const std::size_t before = bench::allocations();
  for (std::size_t i = 0; i < 100; ++i) {
    ASSERT_NE(stages.process(samples[i], processed, link), StageStatus::kDrop);
    const std::int64_t arrival_ns = start_ns + static_cast<std::int64_t>(i) * 1'000'000;
    rehearsal.before_next(stages, samples[i], arrival_ns, arrival_ns - 500'000);
  }
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_GT(rehearsal.count(), 10U);
}

}  // namespace
}  // namespace stillpoint::pipeline

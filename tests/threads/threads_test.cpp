/// The two threads together; run under ThreadSanitizer by the preset `tsan`.
#include <gtest/gtest.h>

#include <bit>
#include <memory>
#include <thread>

#include "pipeline/calibration_loop.h"
#include "pipeline/sources.h"
#include "tests/pipeline/samples.h"

namespace stillpoint::pipeline {
namespace {

struct Collect {
  std::vector<AttitudeMessage> messages;
  bool publish(const AttitudeMessage& m) noexcept {
    messages.push_back(m);
    return true;
  }
};

/// A slow thread that takes its time: `pause_ms` before every window's answer is seen by nobody else.
struct Watch {
  int pause_ms = 0;
  std::size_t samples = 0, calibrations = 0, ticks = 0;
  void on_sample(const Outgoing&) { ++samples; }
  void on_calibration(const Evidence&, const CalibrationSnapshot&) {
    ++calibrations;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
  }
  void on_tick(const SensorReport&, std::int64_t) { ++ticks; }
};

std::vector<AttitudeMessage> offline(const std::vector<RawSample>& samples) {
  calib::OnlineCalibrator calibrator({}, {});
  DirectLink link(calibrator);
  Stages stages(StagesParams{}, calibrator.snapshot());
  std::vector<AttitudeMessage> out;
  Processed processed;
  for (const auto& sample : samples)
    if (stages.process(sample, processed, link) != StageStatus::kDrop) out.push_back(to_message(processed));
  return out;
}

struct Run {
  std::vector<AttitudeMessage> messages;
  std::uint64_t rehearsals = 0;
};

/// `speed` and `rehearse_ahead_s` as in the configuration.
Run in_two_threads(const std::vector<RawSample>& samples, Watch& watch, double poll_s, double speed = 0.0,
                   double rehearse_ahead_s = 0.0) {
  const auto shared = std::make_unique<Shared>();
  calib::OnlineCalibrator calibrator({}, {});
  PacedSource source(MemorySource(samples), speed);
  Stages stages(StagesParams{}, calibrator.snapshot());
  Collect sink;
  SensorLoop<decltype(source), Collect> sensor(source, stages, sink, *shared, OnLateAnswer::kWait, rehearse_ahead_s);
  CalibrationLoop<Watch> calibration(calibrator, *shared, watch, poll_s);
  std::thread slow([&] { calibration.run(); });
  std::thread fast([&] { sensor.run(AtEnd::kStop); });
  fast.join();
  slow.join();
  EXPECT_EQ(stages.counts().answers_late, 0U);
  EXPECT_EQ(watch.samples + shared->outgoing.dropped(), samples.size());
  return {sink.messages, sensor.rehearsals()};
}

void expect_the_same_bits(const std::vector<AttitudeMessage>& got, const std::vector<AttitudeMessage>& expected) {
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    ASSERT_EQ(got[i].calibration_version, expected[i].calibration_version) << "sample " << i;
    for (std::size_t k = 0; k < 4; ++k)
      ASSERT_EQ(std::bit_cast<std::uint64_t>(got[i].q_world_body_xyzw[k]),
                std::bit_cast<std::uint64_t>(expected[i].q_world_body_xyzw[k]))
          << "sample " << i;
  }
}

TEST(Threads, GiveTheSameBitsAsOneThreadHoweverSlowTheCalibrationIs) {
  const auto samples = test::hand_samples(40.0);
  const auto expected = offline(samples);
  ASSERT_GT(expected.back().calibration_version, 1U) << "nothing was learnt: the test would prove nothing";
  for (const int pause_ms : {0, 3}) {
    Watch watch{.pause_ms = pause_ms};
    const auto got = in_two_threads(samples, watch, pause_ms == 0 ? 1e-4 : 5e-3);
    EXPECT_GT(watch.calibrations, 1U);
    expect_the_same_bits(got.messages, expected);
  }
}

TEST(Rehearsal, ChangesNothingOfWhatIsPublished) {
  const auto samples = test::hand_samples(40.0);
  Watch watch;
  const auto got = in_two_threads(samples, watch, 1e-4, 10.0, 90e-6);
  EXPECT_GT(got.rehearsals, 100U) << "hardly ever rehearsed: the test would prove nothing";
  expect_the_same_bits(got.messages, offline(samples));
}

TEST(Rehearsal, ExpectsTheNextSampleOneStepAfterTheLastAndNotLaterWhenSomeWereLost) {
  constexpr std::int64_t kStep_ns = 1'000'000;
  ArrivalForecast forecast;
  EXPECT_FALSE(forecast.next_ns().has_value());
  std::int64_t t_ns = 7'000'000'000;
  forecast.arrived(t_ns);
  EXPECT_FALSE(forecast.next_ns().has_value()) << "one arrival has no step";
  for (int i = 0; i < 10; ++i) forecast.arrived(t_ns += kStep_ns);
  EXPECT_EQ(forecast.next_ns(), t_ns + kStep_ns);
  forecast.arrived(t_ns += 10 * kStep_ns);  // nine were lost
  EXPECT_LT(*forecast.next_ns(), t_ns + kStep_ns + kStep_ns / 100);
  forecast.arrived(t_ns += kStep_ns / 2);  // one came early: expected too early once, then as before
  EXPECT_EQ(forecast.next_ns(), t_ns + kStep_ns / 2);
  for (int i = 0; i < 1000; ++i) forecast.arrived(t_ns += kStep_ns);
  EXPECT_NEAR(static_cast<double>(*forecast.next_ns() - t_ns), kStep_ns, 1e-3 * kStep_ns);
}

TEST(Rehearsal, ExpectsTheNextSampleWhereItWouldComeWithoutLateness) {
  constexpr std::int64_t kStep_ns = 1'000'000;
  ArrivalForecast forecast;
  std::int64_t worst_early_ns = 0, worst_late_ns = 0;
  for (int i = 1; i < 2000; ++i) {
    const std::int64_t late_ns = (i * 7919) % 50'000;  // of a thread that wakes up to 50 us late
    forecast.arrived(i * kStep_ns + late_ns);
    if (i < 500) continue;
    const std::int64_t error_ns = *forecast.next_ns() - (i + 1) * kStep_ns;
    worst_early_ns = std::min(worst_early_ns, error_ns);
    worst_late_ns = std::max(worst_late_ns, error_ns);
  }
  EXPECT_GT(worst_early_ns, -10'000);
  EXPECT_LT(worst_late_ns, 20'000);
}

TEST(Rehearsal, FollowsASensorThatBecomesFasterAtOnce) {
  ArrivalForecast forecast;
  std::int64_t t_ns = 0;
  for (int i = 0; i < 100; ++i) forecast.arrived(t_ns += 10'000'000);
  forecast.arrived(t_ns += 1'000'000);
  EXPECT_EQ(forecast.next_ns(), t_ns + 1'000'000) << "a later one would delay the sample";
}

/// Readings that wait in a socket until they are asked for, a second at 100 Hz and one at 400 Hz; only when each was
/// read is known, as of datagrams.
class Socket {
 public:
  explicit Socket(std::vector<RawSample> samples) : samples_(std::move(samples)) {}
  SourceState next(Arrival& out) noexcept {
    if (at_ == 500) return SourceState::kEnd;
    sleep_until_ns(due_ns(at_));
    out = {samples_[at_], monotonic_ns(), {}};
    out.sample.t_ns = due_ns(at_) - start_ns_ + 1;
    if (++at_ == 400)
      while (due_ns(at_ + waiting_) < out.arrival_ns) ++waiting_;
    return SourceState::kSample;
  }
  [[nodiscard]] bool live() const noexcept { return true; }
  /// Behind the 400th.
  [[nodiscard]] std::size_t waiting() const noexcept { return waiting_; }

 private:
  [[nodiscard]] std::int64_t due_ns(std::size_t i) const noexcept {
    const auto n = static_cast<std::int64_t>(i);
    return start_ns_ + 10'000'000 * std::min<std::int64_t>(n, 100) + 2'500'000 * std::max<std::int64_t>(n - 100, 0);
  }
  std::vector<RawSample> samples_;
  std::int64_t start_ns_ = monotonic_ns();
  std::size_t at_ = 0, waiting_ = 0;
};

/// A forecast from when readings were read expects them as rarely as they are read.
TEST(Rehearsal, LetsNothingWaitInASocketWhenItsSensorBecomesFaster) {
  const auto shared = std::make_unique<Shared>();
  Socket source(test::hand_samples(10.0));
  Stages stages(StagesParams{}, CalibrationSnapshot{});
  Collect sink;
  SensorLoop<Socket, Collect> sensor(source, stages, sink, *shared, OnLateAnswer::kGoOn, 90e-6);
  sensor.run(AtEnd::kStop);
  EXPECT_LT(source.waiting(), 100U) << "a quarter of a second";
  EXPECT_GT(sensor.rehearsals(), 50U) << "hardly ever rehearsed: the test would prove nothing";
}

TEST(Rehearsal, ExpectsNothingOfASensorThatIsRare) {
  ArrivalForecast forecast;
  for (int i = 0; i < 10; ++i) forecast.arrived(1 + i * 200'000'000L);
  EXPECT_FALSE(forecast.next_ns().has_value());
}

TEST(Threads, ALiveSensorNeverWaitsForAnAnswerAndTheLatenessIsCounted) {
  const std::atomic<bool> stop{false};
  const auto channel = std::make_unique<CalibrationChannel>();  // nobody answers
  ThreadLink link(*channel, OnLateAnswer::kGoOn, stop);
  Stages stages(StagesParams{}, CalibrationSnapshot{});
  Processed processed;
  std::size_t published = 0;
  const auto samples = test::hand_samples(40.0);
  for (const auto& sample : samples)
    published += stages.process(sample, processed, link) != StageStatus::kDrop ? 1U : 0U;
  EXPECT_EQ(published, samples.size());
  EXPECT_GT(stages.counts().answers_late, 0U);
  EXPECT_EQ(stages.live().version, 0U);
}

TEST(Threads, AStopEndsAWaitForAnAnswerThatNeverComes) {
  std::atomic<bool> stop{false};
  const auto channel = std::make_unique<CalibrationChannel>();
  ThreadLink link(*channel, OnLateAnswer::kWait, stop);
  std::thread waiting([&] { EXPECT_FALSE(link.answer(1).has_value()); });
  stop.store(true);
  waiting.join();
}

TEST(Threads, TheRingsBetweenTheThreadsLoseNothingTheyAcceptedAndKeepTheOrder) {
  const auto channel = std::make_unique<CalibrationChannel>();
  constexpr std::uint64_t kCount = 20'000;
  std::thread writer([&] {
    Evidence evidence;
    for (std::uint64_t n = 0; n < kCount;) {
      if (!channel->evidence.try_pop(evidence)) {
        std::this_thread::yield();
        continue;
      }
      CalibrationAnswer answer{evidence.number, {}};
      answer.snapshot.version = evidence.number;
      answer.snapshot.mag.norm_sd = static_cast<double>(evidence.number);
      ASSERT_TRUE(channel->answers.try_push(answer));
      n = evidence.number;
    }
  });
  const std::atomic<bool> stop{false};
  ThreadLink link(*channel, OnLateAnswer::kWait, stop);
  for (std::uint64_t n = 1; n <= kCount; ++n) {
    ASSERT_TRUE(link.submit({n, {}}));
    if (n % 16 != 0) continue;  // answers between are left out
    const auto answer = link.answer(n);
    ASSERT_TRUE(answer.has_value());
    ASSERT_EQ(answer->number, n);
    ASSERT_EQ(answer->snapshot.version, n);
    ASSERT_EQ(answer->snapshot.mag.norm_sd, static_cast<double>(n));
  }
  writer.join();
}

}  // namespace
}  // namespace stillpoint::pipeline

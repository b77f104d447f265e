/// Keeps the sensor thread's processor warm. While it slept for the next sample, others have taken the caches, the
/// address translation and the branch history of the stages; prefetching brings little of it back, running the code
/// does (docs/latency.md). So shortly before the next sample is due, when nothing waits, the stages run once on a copy
/// of themselves.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>

#include "pipeline/clock.h"
#include "pipeline/stages.h"

namespace stillpoint::pipeline {

/// When the next sample may be expected, from the arrivals so far: their earliest course, as a thread wakes late but
/// never early.
class ArrivalForecast {
 public:
  /// `count`: so many since the last one that was told.
  void arrived(std::int64_t t_ns, std::int64_t count = 1) noexcept {
    if (last_ns_ != 0) step_ns_ = usual((t_ns - last_ns_) / count);
    last_ns_ = t_ns;
    const std::int64_t late_ns = t_ns - next_ns_;
    next_ns_ = (late_ns > 0 && late_ns < step_ns_ / 2 ? next_ns_ + late_ns / 16 : t_ns) + step_ns_;
  }
  [[nodiscard]] std::int64_t step_ns() const noexcept { return step_ns_; }
  /// None before the second arrival, after arrivals that did not follow one another, and when samples come so rarely
  /// (below 10 Hz) that a request to stop would wait for it.
  [[nodiscard]] std::optional<std::int64_t> next_ns() const noexcept {
    if (step_ns_ <= 0 || step_ns_ > kLongest_ns) return std::nullopt;
    return next_ns_;
  }

 private:
  static constexpr std::int64_t kLongest_ns = 100'000'000;

  /// A rehearsal that comes too late would delay a sample, one that comes too early only warms less. So a step that is
  /// longer once (lost samples) counts little, a much shorter one at once.
  [[nodiscard]] std::int64_t usual(std::int64_t step_ns) const noexcept {
    if (step_ns < step_ns_ - step_ns_ / 4) return step_ns;
    return step_ns_ + std::min((step_ns - step_ns_) / 16, step_ns_ / 256 + 1);
  }

  std::int64_t last_ns_ = 0;
  std::int64_t next_ns_ = 0;
  std::int64_t step_ns_ = 2 * kLongest_ns;
};

class Rehearsal {
 public:
  /// `ahead_s`: before the expected arrival; 0: never.
  Rehearsal(const Stages& stages, double ahead_s) noexcept
      : copy_(stages), ahead_ns_(static_cast<std::int64_t>(1e9 * ahead_s)) {}

  /// After a sample is dealt with that the source was asked for at `asked_ns`. Sleeps in steps until shortly before the
  /// next one, with a run after each, and returns then; at once when that time has passed. A sample that was there when
  /// it was asked for came nobody knows when - a datagram's arrival is when it was read -, and others may wait behind
  /// it.
  void before_next(const Stages& stages, const RawSample& last, std::int64_t arrival_ns,
                   std::int64_t asked_ns) noexcept {
    if (ahead_ns_ == 0) return;
    ++came_;
    if (arrival_ns - asked_ns < ahead_ns_ / kWaitedFor) return;
    forecast_.arrived(arrival_ns, came_);
    came_ = 0;
    const auto next_ns = forecast_.next_ns();
    if (!next_ns || forecast_.step_ns() < kWorth * ahead_ns_) return;
    RawSample expected = last;
    expected.t_ns += static_cast<std::int64_t>(1e9 * stages.guard().usual_step_s());
    ++expected.sequence;
    for (std::int64_t step = kSteps; step > 0; --step) {
      const std::int64_t wake_ns = *next_ns - ahead_ns_ * step / kSteps;
      if (wake_ns <= monotonic_ns()) continue;
      sleep_until_ns(wake_ns);
      copy_ = stages;
      NoLink link;
      copy_.process(expected, processed_, link);
      ++count_;
    }
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  /// A processor that sleeps for less than this many leads stays warm enough; waking it more often would only add to
  /// the tail.
  static constexpr std::int64_t kWorth = 8;
  /// A part of the lead, which is slept away in the kernel before a sample that comes as forecast.
  static constexpr std::int64_t kWaitedFor = 4;
  /// The shorter the last sleep, the less is lost in it; but a sleep that follows a long one wakes late.
  static constexpr std::int64_t kSteps = 3;

  /// What a rehearsal finds is nobody's evidence.
  struct NoLink {
    bool submit(const Evidence&) noexcept { return false; }
    std::optional<CalibrationAnswer> answer(std::uint64_t) noexcept { return std::nullopt; }
  };

  Stages copy_;  // of fixed size throughout: copying allocates nothing
  Processed processed_;
  ArrivalForecast forecast_;
  std::int64_t ahead_ns_;
  std::int64_t came_ = 0;  ///< since the last that was waited for
  std::uint64_t count_ = 0;
};

}  // namespace stillpoint::pipeline

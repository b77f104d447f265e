/// Sources without hardware: samples kept in memory, pacing to the wall clock, and a source that misbehaves on purpose.
#pragma once
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/clock.h"
#include "pipeline/stage.h"

namespace stillpoint::pipeline {

/// The samples of a recording, as fast as they are asked for.
class MemorySource {
 public:
  explicit MemorySource(std::vector<RawSample> samples) noexcept : samples_(std::move(samples)) {}
  SourceState next(Arrival& out) noexcept {
    if (next_ == samples_.size()) return SourceState::kEnd;
    out.sample = samples_[next_++];
    out.arrival_ns = monotonic_ns();
    return SourceState::kSample;
  }

 private:
  std::vector<RawSample> samples_;
  std::size_t next_ = 0;
};

/// Hands on the samples of another source when they are due: `factor` times real time, 0 as fast as they are
/// asked for. Sleeps on absolute time, so no error adds up; a sample that could not be handed on in time keeps the time
/// at which it was due.
template <Source S>
class PacedSource {
 public:
  PacedSource(S source, double factor) noexcept : source_(std::move(source)), factor_(factor) {}

  SourceState next(Arrival& out) noexcept {
    if (factor_ <= 0.0) return source_.next(out);
    prepare();
    if (*drawn_ != SourceState::kSample) return *std::exchange(drawn_, std::nullopt);
    if (!started_) {
      start_ns_ = monotonic_ns();
      first_ns_ = pending_.sample.t_ns;
      started_ = true;
    }
    const double due_ns = static_cast<double>(pending_.sample.t_ns - first_ns_) / factor_;
    pending_.arrival_ns = start_ns_ + static_cast<std::int64_t>(std::clamp(due_ns, -kLongest_ns, kLongest_ns));
    // A long pause in the recording is slept in pieces, so that a request to stop is noticed.
    const std::int64_t now = monotonic_ns();
    if (pending_.arrival_ns > now + kLongestSleep_ns) {
      sleep_until_ns(now + kLongestSleep_ns);
      return SourceState::kNothing;
    }
    sleep_until_ns(pending_.arrival_ns);
    out = pending_;
    drawn_.reset();
    return SourceState::kSample;
  }

  /// Draws the next sample ahead of its time: a simulator's work is done before, not between waking and sleeping.
  void prepare() noexcept {
    if (factor_ > 0.0 && !drawn_) drawn_ = source_.next(pending_);
  }
  [[nodiscard]] bool live() const noexcept { return is_live(source_); }

 private:
  static constexpr std::int64_t kLongestSleep_ns = 100'000'000;
  static constexpr double kLongest_ns = 1e18;  // 30 years: what is due later is not awaited
  S source_;
  double factor_;
  Arrival pending_;
  std::int64_t start_ns_ = 0, first_ns_ = 0;
  std::optional<SourceState> drawn_;  ///< what the other source has answered and nobody has been told yet
  bool started_ = false;
};

static_assert(Source<MemorySource> && Source<PacedSource<MemorySource>>);

}  // namespace stillpoint::pipeline

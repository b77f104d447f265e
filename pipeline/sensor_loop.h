/// The sensor thread: source -> stages -> best-effort write, and a copy into a ring for everything slow.
/// Wait-free between `next` and `publish`: no lock, no allocation, no text, no system call but the clock and the write.
#pragma once
#include <algorithm>
#include <atomic>

#include "core/attitude_message.h"
#include "core/snapshot_cell.h"
#include "pipeline/rehearsal.h"
#include "pipeline/stages.h"

namespace stillpoint::pipeline {

enum class SensorState : std::uint8_t { kWaiting, kRunning, kGone, kEnded };

/// What the slow thread gets of each sample.
struct Outgoing {
  RawSample raw;  ///< as it came from the source
  std::int64_t arrival_ns = 0;
  bool published = false;  ///< false: refused by a stage; what follows is not filled
  AttitudeMessage message;
  CalibratedSample sample;  ///< corrected and compensated, in the sensor's frame
};

/// Counters for the diagnostics; copied out a few times a second.
struct SensorReport {
  SensorState state = SensorState::kWaiting;
  GuardCounts guard;
  StagesCounts stages;
  std::int64_t last_arrival_ns = 0;  ///< 0: no sample yet
  std::uint64_t published = 0;
  std::uint64_t write_failures = 0;
  std::uint64_t ring_dropped = 0;
  double usual_step_s = 0.0;
  std::array<double, kSampleParts> usual_steps_s{};  ///< between readings of each part
  std::uint64_t rounds = 0;                          ///< grows as long as the sensor thread goes on, samples or not
  calib::Refusal last_refusal = calib::Refusal::kNone;
  SensorsHealth health = unheard();
  std::array<Finding, kOddities> findings{};
  std::size_t found = 0;  ///< of these
};

/// Everything that the two threads share.
struct Shared {
  CalibrationChannel calibration;
  SpscRing<Outgoing, 4096> outgoing;  ///< a second at 4 kHz: so long the calibration thread may be kept from running
  SnapshotCell<SensorReport> report;
  LatencyHistogram latency;              ///< arrival to just before the write: lateness of the wake-up included
  LatencyHistogram processing;           ///< of that, what the stages take
  std::atomic<bool> stop{false};         ///< asks both threads to end
  std::atomic<bool> sensor_done{false};  ///< nothing more will enter the rings
};

enum class AtEnd : std::uint8_t { kStop, kWait };

template <Source S, Sink<AttitudeMessage> Out>
class SensorLoop {
 public:
  /// All of these live longer than the loop. `rehearse_ahead_s`: see Rehearsal; 0 for a source that is not paced by
  /// time.
  SensorLoop(S& source, Stages& stages, Out& sink, Shared& shared, OnLateAnswer late, double rehearse_ahead_s) noexcept
      : source_(source),
        stages_(stages),
        sink_(sink),
        shared_(shared),
        link_(shared.calibration, late, shared.stop),
        rehearsal_(stages, rehearse_ahead_s) {}

  [[nodiscard]] std::uint64_t rehearsals() const noexcept { return rehearsal_.count(); }

  /// Returns when asked to stop, or at the end of the source if that is what the end means.
  void run(AtEnd at_end) noexcept {
    while (!shared_.stop.load(std::memory_order_relaxed)) {
      const std::int64_t asked_ns = monotonic_ns();
      const SourceState state = source_.next(arrival_);
      if (state == SourceState::kSample) {
        handle();
        prepare(source_);
        rehearsal_.before_next(stages_, arrival_.sample, arrival_.arrival_ns, asked_ns);
      } else if (state == SourceState::kGone || state == SourceState::kEnd) {
        change_state(state == SourceState::kGone ? SensorState::kGone : SensorState::kEnded);
        if (state == SourceState::kEnd && at_end == AtEnd::kStop) break;
        sleep_until_ns(monotonic_ns() + kRetry_ns);
      } else {
        report();
      }
    }
    report();
    shared_.sensor_done.store(true, std::memory_order_release);
  }

 private:
  static constexpr std::int64_t kRetry_ns = 50'000'000;
  static constexpr std::int64_t kReportPeriod_ns = 20'000'000;

  void handle() noexcept {
    const std::int64_t start_ns = monotonic_ns();
    if (counts_.state == SensorState::kGone) stages_.source_returned();
    stages_.hear(arrival_.noise);
    const bool usable = stages_.process(arrival_.sample, result_, link_) != StageStatus::kDrop;
    const std::int64_t now_ns = monotonic_ns();
    shared_.processing.add(now_ns - start_ns);
    if (usable) {
      out_.message = to_message(result_);
      out_.message.t_arrival_ns = arrival_.arrival_ns;
      out_.message.gaps = stages_.guard().counts().gaps;
      out_.message.dropped = shared_.outgoing.dropped() + counts_.write_failures;
      shared_.latency.add(now_ns - arrival_.arrival_ns);
      ++(sink_.publish(out_.message) ? counts_.published : counts_.write_failures);
    }
    out_.raw = arrival_.sample;
    out_.arrival_ns = arrival_.arrival_ns;
    out_.published = usable;
    out_.sample = result_.sample;
    shared_.outgoing.try_push(out_);
    counts_.state = SensorState::kRunning;
    if (now_ns >= next_report_ns_) report();
  }

  void change_state(SensorState state) noexcept {
    counts_.state = state;
    report();
  }

  void report() noexcept {
    ++counts_.rounds;
    counts_.last_arrival_ns = arrival_.arrival_ns;
    counts_.guard = stages_.guard().counts();
    counts_.stages = stages_.counts();
    counts_.ring_dropped = shared_.outgoing.dropped();
    counts_.usual_step_s = stages_.guard().usual_step_s();
    counts_.usual_steps_s = stages_.guard().usual_steps_s();
    counts_.last_refusal = stages_.last_refusal();
    counts_.health = stages_.health();
    const auto findings = stages_.findings();
    counts_.found = findings.size();
    std::copy(findings.begin(), findings.end(), counts_.findings.begin());
    shared_.report.store(counts_);
    next_report_ns_ = monotonic_ns() + kReportPeriod_ns;
  }

  S& source_;
  Stages& stages_;
  Out& sink_;
  Shared& shared_;
  ThreadLink link_;
  Rehearsal rehearsal_;
  Arrival arrival_;
  Processed result_;
  Outgoing out_;
  SensorReport counts_;
  std::int64_t next_report_ns_ = 0;
};

}  // namespace stillpoint::pipeline

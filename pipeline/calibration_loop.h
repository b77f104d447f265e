/// The calibration thread: learns from the evidence, answers the sensor thread, and serves an observer that does
/// everything slow (reliable topics, diagnostics, persistence, logging).
#pragma once
#include "pipeline/sensor_loop.h"

namespace stillpoint::pipeline {

/// All calls come from the calibration thread.
template <class O>
concept Observer = requires(O observer, const Outgoing& sample, const Evidence& evidence,
                            const CalibrationSnapshot& snapshot, const SensorReport& report, std::int64_t now_ns) {
  observer.on_sample(sample);
  observer.on_calibration(evidence, snapshot);  ///< the snapshot changed
  observer.on_tick(report, now_ns);             ///< once a second, and once at the end
};

template <Observer O>
class CalibrationLoop {
 public:
  CalibrationLoop(calib::OnlineCalibrator& calibrator, Shared& shared, O& observer, double poll_s) noexcept
      : calibrator_(calibrator),
        shared_(shared),
        observer_(observer),
        poll_ns_(static_cast<std::int64_t>(1e9 * poll_s)) {}

  /// Returns when the sensor thread is done and the rings are empty.
  void run() {
    std::int64_t next_tick_ns = monotonic_ns() + kTick_ns;
    while (true) {
      const bool last_round = shared_.sensor_done.load(std::memory_order_acquire);
      drain();
      const std::int64_t now_ns = monotonic_ns();
      if (last_round || now_ns >= next_tick_ns) {
        next_tick_ns += kTick_ns * (1 + (now_ns - next_tick_ns) / kTick_ns);
        if (const auto report = shared_.report.try_load()) report_ = *report;
        observer_.on_tick(report_, now_ns);
      }
      if (last_round) return;
      sleep_until_ns(now_ns + poll_ns_);
    }
  }

 private:
  static constexpr std::int64_t kTick_ns = 1'000'000'000;

  void drain() {
    learn();
    while (shared_.outgoing.try_pop(sample_)) {
      observer_.on_sample(sample_);
      learn();  // a waiting sensor thread comes before slow readers
    }
  }

  void learn() {
    while (shared_.calibration.evidence.try_pop(evidence_)) {
      const bool changed = evidence_.teach(calibrator_);
      shared_.calibration.answers.try_push({evidence_.number, calibrator_.snapshot()});
      if (changed) observer_.on_calibration(evidence_, calibrator_.snapshot());
    }
  }

  calib::OnlineCalibrator& calibrator_;
  Shared& shared_;
  O& observer_;
  std::int64_t poll_ns_;
  SensorReport report_;
  Outgoing sample_;  ///< the one just taken from its ring
  Evidence evidence_;
};

}  // namespace stillpoint::pipeline

/// The way from a rest window to the parameters learnt from it (docs/decisions/070-deterministic-calibration.md).
/// Windows are numbered. The parameters after window n take effect at the first sample at or after the window's end
/// plus a fixed delay: a rule about sample times only, so a replay gives the same bits at any speed and on any machine.
#pragma once
#include <concepts>
#include <cstdint>
#include <optional>

#include "calib_online/online_calibrator.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/snapshot_cell.h"
#include "core/spsc_ring.h"
#include "pipeline/clock.h"

namespace stillpoint::pipeline {

struct NumberedWindow {
  std::uint64_t number = 0;  ///< 1 for the first of a run
  calib::Window window;
};

/// What is in force after all windows up to `number`.
struct CalibrationAnswer {
  std::uint64_t number = 0;
  CalibrationSnapshot snapshot;
};

/// The sensor thread's end. `answer` gives what is known at or beyond window `number`; none: not learnt yet.
template <class L>
concept CalibrationLink = requires(L link, const NumberedWindow& window, std::uint64_t number) {
  { link.submit(window) }
  noexcept->std::same_as<bool>;
  { link.answer(number) }
  noexcept->std::same_as<std::optional<CalibrationAnswer>>;
};

/// One thread for everything: learns at once, answers when asked.
class DirectLink {
 public:
  explicit DirectLink(calib::OnlineCalibrator& calibrator) noexcept : calibrator_(calibrator) {}
  bool submit(const NumberedWindow& window) noexcept {
    calibrator_.absorb(window.window);
    number_ = window.number;
    return true;
  }
  std::optional<CalibrationAnswer> answer(std::uint64_t number) noexcept {
    if (number_ < number) return std::nullopt;
    return CalibrationAnswer{number_, calibrator_.snapshot()};
  }

 private:
  calib::OnlineCalibrator& calibrator_;
  std::uint64_t number_ = 0;
};

/// Between the two threads: windows go out by a ring, answers come back by a one-writer cell.
struct CalibrationChannel {
  SpscRing<NumberedWindow, 64> windows;
  SnapshotCell<CalibrationAnswer> answers;
};

enum class OnLateAnswer : std::uint8_t {
  kWait,  ///< a replay: the sample waits, so that the result does not depend on the machine
  kGoOn,  ///< a live sensor: the sample goes on with the old parameters; the lateness is counted
};

class ThreadLink {
 public:
  /// `stop` ends a wait, from any thread.
  ThreadLink(CalibrationChannel& channel, OnLateAnswer late, const std::atomic<bool>& stop) noexcept
      : channel_(channel), late_(late), stop_(stop) {}

  bool submit(const NumberedWindow& window) noexcept { return channel_.windows.try_push(window); }

  std::optional<CalibrationAnswer> answer(std::uint64_t number) noexcept {
    while (true) {
      const auto latest = channel_.answers.try_load();
      if (latest && latest->number >= number) return latest;
      if (late_ == OnLateAnswer::kGoOn || stop_.load(std::memory_order_relaxed)) return std::nullopt;
      sleep_until_ns(monotonic_ns() + kWait_ns);
    }
  }

 private:
  static constexpr std::int64_t kWait_ns = 50'000;
  CalibrationChannel& channel_;
  OnLateAnswer late_;
  const std::atomic<bool>& stop_;
};

static_assert(CalibrationLink<DirectLink> && CalibrationLink<ThreadLink>);

}  // namespace stillpoint::pipeline

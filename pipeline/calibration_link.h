/// The way from the evidence to the parameters learnt from it (docs/decisions/070-deterministic-calibration.md).
/// Evidence is numbered. The parameters after number n take effect at the first sample at or after its end plus a
/// fixed delay: a rule about sample times only, so a replay gives the same bits at any speed and on any machine.
#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <variant>

#include "calib_online/field_turns.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/window.h"
#include "core/calibration.h"
#include "core/spsc_ring.h"
#include "pipeline/clock.h"

namespace stillpoint::pipeline {

struct Evidence {
  std::uint64_t number = 0;  ///< 1 for the first of a run
  std::variant<calib::Window, calib::FieldTurn> found;

  /// The end of the window or of the turn.
  [[nodiscard]] std::int64_t t_end_ns() const noexcept {
    return std::visit([](const auto& e) { return e.t_end_ns; }, found);
  }
  [[nodiscard]] double temp_degC() const noexcept {
    return std::visit([](const auto& e) { return e.temp_degC; }, found);
  }
  /// True when the snapshot changed.
  bool teach(calib::OnlineCalibrator& calibrator) const noexcept {
    return std::visit([&calibrator](const auto& e) { return calibrator.absorb(e); }, found);
  }
};

/// What is in force after all evidence up to `number`.
struct CalibrationAnswer {
  std::uint64_t number = 0;
  CalibrationSnapshot snapshot;
};

/// The sensor thread's end. `answer` gives what was known after evidence `number`; none: not learnt yet. Numbers are
/// asked for in order, each at most until it was given; those between may be left out.
template <class L>
concept CalibrationLink = requires(L link, const Evidence& evidence, std::uint64_t number) {
  { link.submit(evidence) }
  noexcept->std::same_as<bool>;
  { link.answer(number) }
  noexcept->std::same_as<std::optional<CalibrationAnswer>>;
};

/// Evidence that can be on its way at a time, and so many answers: at two a second more than the longest delay holds.
inline constexpr std::size_t kMostOnTheWay = 64;

/// One thread for everything: learns at once, answers when asked.
class DirectLink {
 public:
  explicit DirectLink(calib::OnlineCalibrator& calibrator) noexcept : calibrator_(calibrator) {}
  bool submit(const Evidence& evidence) noexcept {
    evidence.teach(calibrator_);
    last_ = evidence.number;
    answers_[last_ % kMostOnTheWay] = calibrator_.snapshot();
    return true;
  }
  std::optional<CalibrationAnswer> answer(std::uint64_t number) noexcept {
    if (last_ < number) return std::nullopt;
    return CalibrationAnswer{number, answers_[number % kMostOnTheWay]};
  }

 private:
  calib::OnlineCalibrator& calibrator_;
  std::array<CalibrationSnapshot, kMostOnTheWay> answers_{};
  std::uint64_t last_ = 0;
};

/// Between the two threads: evidence goes out by one ring, one answer to each comes back by another.
struct CalibrationChannel {
  SpscRing<Evidence, kMostOnTheWay> evidence;
  SpscRing<CalibrationAnswer, 2 * kMostOnTheWay> answers;
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

  bool submit(const Evidence& evidence) noexcept { return channel_.evidence.try_push(evidence); }

  std::optional<CalibrationAnswer> answer(std::uint64_t number) noexcept {
    while (true) {
      while (last_.number < number && channel_.answers.try_pop(last_)) continue;
      if (last_.number >= number) return last_;
      if (late_ == OnLateAnswer::kGoOn || stop_.load(std::memory_order_relaxed)) return std::nullopt;
      sleep_until_ns(monotonic_ns() + kWait_ns);
    }
  }

 private:
  static constexpr std::int64_t kWait_ns = 50'000;
  CalibrationChannel& channel_;
  CalibrationAnswer last_;  ///< taken off the ring
  OnLateAnswer late_;
  const std::atomic<bool>& stop_;
};

static_assert(CalibrationLink<DirectLink> && CalibrationLink<ThreadLink>);

}  // namespace stillpoint::pipeline

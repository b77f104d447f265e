/// Which evidence's parameters take effect when: each a fixed delay after its end, whatever came after it. Evidence
/// that comes faster than the delay would otherwise put the answer off for ever
/// (docs/decisions/070-deterministic-calibration.md).
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "pipeline/calibration_link.h"

namespace stillpoint::pipeline {

class AnswerSchedule {
 public:
  [[nodiscard]] bool full() const noexcept { return last_ - taken_ == kMostOnTheWay; }
  /// Number of the next piece of evidence.
  [[nodiscard]] std::uint64_t next() const noexcept { return last_ + 1; }
  void submitted(std::int64_t due_ns) noexcept { due_ns_[++last_ % kMostOnTheWay] = due_ns; }

  /// The newest number that is due and was not taken.
  [[nodiscard]] std::optional<std::uint64_t> due(std::int64_t t_ns) const noexcept {
    std::uint64_t number = taken_;
    while (number < last_ && due_ns_[(number + 1) % kMostOnTheWay] <= t_ns) ++number;
    if (number == taken_) return std::nullopt;
    return number;
  }
  void taken(std::uint64_t number) noexcept { taken_ = number; }

 private:
  std::array<std::int64_t, kMostOnTheWay> due_ns_{};
  std::uint64_t last_ = 0, taken_ = 0;  ///< numbers of evidence: handed out, and answered
};

}  // namespace stillpoint::pipeline

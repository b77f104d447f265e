/// What is said of each sensor's health, in the log when it falls ill, with the reason, and when it is well again.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "core/health.h"

namespace stillpoint::app {

class HealthWatch {
 public:
  /// What changed since the last call, one line a sensor. A magnetometer or thermometer that never spoke is no news.
  [[nodiscard]] std::vector<std::string> news(const SensorsHealth& now);
  /// Those that are silent now, in one line; empty: none.
  [[nodiscard]] const std::string& silent() const noexcept { return silent_; }

 private:
  struct Told {
    Health state = Health::kOk;
    Fault fault = Fault::kNone;
    bool was_there = false;
  };
  std::array<Told, 4> told_;
  std::string silent_;
};

}  // namespace stillpoint::app

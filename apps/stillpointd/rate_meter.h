/// How many samples a second come, over the time between two looks.
#pragma once
#include <cstdint>

#include "core/units.h"

namespace stillpoint::app {

class RateMeter {
 public:
  explicit RateMeter(std::int64_t start_ns) : since_ns_(start_ns) {}

  /// `samples` so far. A look so soon after the last that a batch of them would count as a rate repeats what was said.
  double look(std::uint64_t samples, std::int64_t now_ns) {
    if (now_ns - since_ns_ < kShortest_ns) return rate_hz_;
    rate_hz_ = static_cast<double>(samples - samples_) / in_seconds(now_ns - since_ns_);
    samples_ = samples;
    since_ns_ = now_ns;
    return rate_hz_;
  }

 private:
  static constexpr std::int64_t kShortest_ns = 500'000'000;
  std::int64_t since_ns_;
  std::uint64_t samples_ = 0;
  double rate_hz_ = 0.0;
};

}  // namespace stillpoint::app

/// When to try again what is gone: after 0.1 s, then twice as long each time, up to a bound.
#pragma once
#include <algorithm>
#include <cstdint>

namespace stillpoint::sources {

class Reopening {
 public:
  static constexpr std::int64_t kFirst_ns = 100'000'000;
  explicit Reopening(double at_most_s) noexcept : longest_ns_(static_cast<std::int64_t>(1e9 * at_most_s)) {}
  [[nodiscard]] bool due(std::int64_t now_ns) const noexcept { return now_ns >= next_ns_; }
  void failed(std::int64_t now_ns) noexcept {
    next_ns_ = now_ns + wait_ns_;
    wait_ns_ = std::min(2 * wait_ns_, longest_ns_);
  }
  /// It has given something: the next loss is a new one.
  void works() noexcept { wait_ns_ = kFirst_ns; }
  [[nodiscard]] std::int64_t next_ns() const noexcept { return next_ns_; }

 private:
  std::int64_t longest_ns_, wait_ns_ = kFirst_ns, next_ns_ = 0;
};

}  // namespace stillpoint::sources

/// The one clock of the daemon, and sleeping on it without drift.
#pragma once
#include <time.h>

#include <cstdint>

namespace stillpoint::pipeline {

/// CLOCK_MONOTONIC in ns (a vDSO read, no system call on Linux).
[[nodiscard]] inline std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Sleeps until an instant of monotonic_ns(). Returns at once when it has passed. A signal may end the sleep early.
inline void sleep_until_ns(std::int64_t t_ns) noexcept {
  const timespec until{static_cast<time_t>(t_ns / 1'000'000'000), static_cast<long>(t_ns % 1'000'000'000)};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace stillpoint::pipeline

/// The system's clocks as nanoseconds.
#pragma once
#include <time.h>

#include <cstdint>

namespace stillpoint {

/// A vDSO read for CLOCK_MONOTONIC and CLOCK_REALTIME, no system call on Linux.
[[nodiscard]] inline std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// The one clock of the daemon and of those who hear it: CLOCK_MONOTONIC.
[[nodiscard]] inline std::int64_t monotonic_ns() noexcept { return clock_ns(CLOCK_MONOTONIC); }

}  // namespace stillpoint

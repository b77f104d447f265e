/// Sleeping on the daemon's clock without drift.
#pragma once
#include <time.h>

#include <cstdint>

#include "core/clock.h"

namespace stillpoint::pipeline {

/// Sleeps until an instant of monotonic_ns(). Returns at once when it has passed. A signal may end the sleep early.
inline void sleep_until_ns(std::int64_t t_ns) noexcept {
  const timespec until{static_cast<time_t>(t_ns / 1'000'000'000), static_cast<long>(t_ns % 1'000'000'000)};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace stillpoint::pipeline

/// What the operating system may do for a thread that must not be late. Each may be refused; the daemon then says so
/// and goes on under normal scheduling.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/fields.h"

namespace stillpoint::pipeline {

struct ThreadParams {
  int sensor_core = -1;
  int calibration_core = -1;
  int fifo_priority = 0;
  bool lock_memory = false;
  double calibration_poll_s = 0.002;
  double rehearse_ahead_s = 120e-6;
  int cpu_latency_us = -1;

  template <class P = ThreadParams>
  static constexpr auto fields() {
    return std::tuple{
        field("sensor_core", &P::sensor_core, in_range(-1, 1023), "core that the sensor thread is pinned to; -1: any"),
        field("calibration_core", &P::calibration_core, in_range(-1, 1023), "the same for the calibration thread"),
        field("fifo_priority", &P::fifo_priority, in_range(0, 99),
              "SCHED_FIFO priority of the sensor thread; 0: normal"),
        field("lock_memory", &P::lock_memory, "keep all memory in RAM (mlockall) and touch the stack before starting"),
        field("calibration_poll_s", &P::calibration_poll_s, in_range(1e-4, 0.1),
              "the calibration thread looks at its rings this often; the sensor thread never wakes it"),
        field("rehearse_ahead_s", &P::rehearse_ahead_s, in_range(0.0, 1e-3),
              "from this long before a sample the sensor thread wakes and warms its caches; 0: never"),
        field(
            "cpu_latency_us", &P::cpu_latency_us, in_range(-1, 1'000'000),
            "no processor of the machine sleeps so deeply that waking takes longer; 0: none sleeps; -1: as the system "
            "decides")};
  }
};

/// Locks all present and future memory and allots the heap that later growth would otherwise fault in.
/// Empty: done. Otherwise what was refused and what to do about it, in one sentence.
[[nodiscard]] std::optional<std::string> lock_memory();

/// Until the process ends no processor enters an idle state that takes longer than this to leave (Linux's power
/// management quality of service, /dev/cpu_dma_latency). It costs power, on all of them. Empty: done, as above.
[[nodiscard]] std::optional<std::string> limit_cpu_latency(int us);

/// For the calling thread: touches the stack it will use, has its sleeps end on time (normal scheduling allows 50 us
/// of slack), pins it and asks for SCHED_FIFO. What was refused, in words.
[[nodiscard]] std::vector<std::string> prepare_thread(const char* name, int core, int fifo_priority);

}  // namespace stillpoint::pipeline

/// What this program has cost so far.
#pragma once
#include <sys/resource.h>

namespace stillpoint::bench {

/// Seconds of processor, the kernel's for it as well.
[[nodiscard]] inline double processor_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

}  // namespace stillpoint::bench

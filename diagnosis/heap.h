/// For programs of which most work is a diagnosis: its tables of some megabytes come and go by the thousand, and glibc
/// would fetch each from the system and give it back. A third of the time and more went there; the peak is the same.
#pragma once
#include <malloc.h>

namespace stillpoint::diag {

inline void keep_freed_memory() noexcept {
  constexpr int kLargest = 32 << 20;  // glibc takes no larger threshold
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, 16 * kLargest);
}

}  // namespace stillpoint::diag

#include "bench/allocations.h"

#include <atomic>

namespace {
std::atomic<std::size_t> count{0};
thread_local std::size_t count_of_thread = 0;

void note() {
  count.fetch_add(1, std::memory_order_relaxed);
  ++count_of_thread;
}
}  // namespace

// glibc's own entry points; what they are wrapped in must not allocate.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t n, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  note();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  note();
  return __libc_calloc(n, size);
}
void* realloc(void* old, std::size_t size) {
  note();
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
}

std::size_t stillpoint::bench::allocations() noexcept { return count.load(std::memory_order_relaxed); }
std::size_t stillpoint::bench::allocations_of_this_thread() noexcept { return count_of_thread; }

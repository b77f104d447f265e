/// Bounded ring between exactly one producer thread and one consumer thread. Wait-free on both sides.
/// Each side keeps a copy of the other's index, so the shared cache line is read only when the copy runs out.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace stillpoint {

template <class T, std::size_t Capacity>
class SpscRing {
  static_assert((Capacity & (Capacity - 1)) == 0, "the capacity is a power of two, so that wrapping is a mask");
  static_assert(std::is_trivially_copyable_v<T>, "elements are copied by the two threads without a lock");

 public:
  /// Producer only. A full ring refuses and counts a drop; it never blocks and never overwrites. Wait-free.
  bool try_push(const T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_seen_ == Capacity) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head - tail_seen_ == Capacity) {
        dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        return false;
      }
    }
    slots_[head & (Capacity - 1)] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Consumer only. False, and `out` untouched, when the ring is empty. Wait-free.
  bool try_pop(T& out) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_seen_) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail == head_seen_) return false;
    }
    out = slots_[tail & (Capacity - 1)];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Any thread.
  [[nodiscard]] std::size_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kCacheLine_bytes = 64;
  alignas(kCacheLine_bytes) std::atomic<std::size_t> head_{0};
  std::size_t tail_seen_ = 0;
  std::atomic<std::size_t> dropped_{0};
  alignas(kCacheLine_bytes) std::atomic<std::size_t> tail_{0};
  std::size_t head_seen_ = 0;
  alignas(kCacheLine_bytes) std::array<T, Capacity> slots_{};
};

}  // namespace stillpoint

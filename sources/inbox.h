/// From the threads that listen (of a wire, of devices) to the sensor thread: bounded, and nobody waits for a reader.
#pragma once
#include <semaphore.h>

#include <atomic>
#include <cstdint>
#include <mutex>

#include "core/clock.h"
#include "core/spsc_ring.h"
#include "sources/reading.h"

namespace stillpoint::sources {

class Inbox {
 public:
  struct Item {
    Reading reading;
    std::int64_t arrival_ns = 0;
  };

  Inbox() { sem_init(&filled_, 0, 0); }
  ~Inbox() { sem_destroy(&filled_); }
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;

  /// Any thread. A full ring loses the reading, and the sequence tells.
  void put(Reading reading, std::int64_t arrival_ns) {
    const std::lock_guard one_writer(mutex_);
    reading.sample.sequence = ++sequence_;
    if (ring_.try_push({reading, arrival_ns}))
      sem_post(&filled_);
    else
      lost.fetch_add(1, std::memory_order_relaxed);
  }
  /// Any thread: so many were lost on their way.
  void skip(std::uint64_t count) {
    const std::lock_guard one_writer(mutex_);
    sequence_ += count;
    lost.fetch_add(count, std::memory_order_relaxed);
  }

  /// The sensor thread. Wait-free.
  bool take(Item& item) noexcept { return ring_.try_pop(item); }
  /// Until something was put, at most 100 ms.
  void wait() noexcept {
    const std::int64_t until_ns = monotonic_ns() + kPatience_ns;
    const timespec until{static_cast<time_t>(until_ns / 1'000'000'000), static_cast<long>(until_ns % 1'000'000'000)};
    sem_clockwait(&filled_, CLOCK_MONOTONIC, &until);
    while (sem_trywait(&filled_) == 0) {  // of what was taken without waiting
    }
  }

  std::atomic<std::uint64_t> malformed{0}, lost{0};

 private:
  static constexpr std::int64_t kPatience_ns = 100'000'000;
  std::mutex mutex_;
  SpscRing<Item, 1024> ring_;  // a second at 1 kHz
  sem_t filled_{};
  std::uint64_t sequence_ = 0;
};

}  // namespace stillpoint::sources

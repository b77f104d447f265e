/// Our ring beside boost::lockfree::spsc_queue, and with a consumer that sleeps beside a futex without a ring, each
/// pair interleaved in the same run so that both meet the same machine: `build/release/bench/micro
/// --benchmark_filter=Ring`. Counters: ns a hop of each (median of the batches), their ratio.
#include <benchmark/benchmark.h>
#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <thread>

#include "bench/allocations.h"
#include "core/median.h"
#include "core/spsc_ring.h"
#include "core/types.h"

namespace stillpoint {
namespace {

constexpr std::size_t kCapacity = 1024;
constexpr int kBatch = 400;  // hops: short enough that most batches are not interrupted

/// The consumer looks until there is something. A core that is shared must let the other thread run.
struct Polled {
  template <class Queue>
  static void take(Queue& queue, RawSample& sample) {
    for (int misses = 0; !queue.pop(sample); ++misses)
      if (misses > 10'000) std::this_thread::yield();
  }
};

struct Ours : Polled {
  SpscRing<RawSample, kCapacity> ring;
  bool push(const RawSample& sample) { return ring.try_push(sample); }
  bool pop(RawSample& sample) { return ring.try_pop(sample); }
};

struct Boost : Polled {
  boost::lockfree::spsc_queue<RawSample, boost::lockfree::capacity<kCapacity>> ring;
  bool push(const RawSample& sample) { return ring.push(sample); }
  bool pop(RawSample& sample) { return ring.pop(sample) == 1; }
};

/// The consumer sleeps until it is woken. Nothing but a count goes from one thread to the other.
struct Futex {
  std::atomic<std::uint32_t> pushed{0};
  std::uint32_t popped = 0;

  bool push(const RawSample&) {
    pushed.fetch_add(1, std::memory_order_release);
    return syscall(SYS_futex, &pushed, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0) >= 0;
  }
  bool pop(RawSample&) {
    if (pushed.load(std::memory_order_acquire) == popped) return false;
    ++popped;
    return true;
  }
  template <class Queue>
  static void take(Queue& queue, RawSample& sample) {
    while (!queue.pop(sample)) syscall(SYS_futex, &queue.pushed, FUTEX_WAIT_PRIVATE, queue.popped, nullptr, nullptr, 0);
  }
};

/// The same, with the samples in a ring.
struct SleepingOurs : Futex {
  SpscRing<RawSample, kCapacity> ring;
  bool push(const RawSample& sample) { return ring.try_push(sample) && Futex::push(sample); }
  bool pop(RawSample& sample) { return Futex::pop(sample) && ring.try_pop(sample); }
};

/// One thread puts in and takes out; ns a hop.
template <class Queue>
double one_thread_ns(Queue& queue) {
  RawSample sample;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kBatch; ++i) {
    sample.sequence = static_cast<std::uint64_t>(i);
    queue.push(sample);
    queue.pop(sample);
    benchmark::DoNotOptimize(sample);
  }
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() / kBatch;
}

/// Keeps the calling thread on a core while it lives: two threads left to the system may share one. Where there is no
/// such core it changes nothing.
class OnCore {
 public:
  explicit OnCore(std::size_t core) {
    cpu_set_t wanted;
    CPU_ZERO(&wanted);
    CPU_SET(core, &wanted);
    sched_getaffinity(0, sizeof before_, &before_);
    sched_setaffinity(0, sizeof wanted, &wanted);
  }
  ~OnCore() { sched_setaffinity(0, sizeof before_, &before_); }
  OnCore(const OnCore&) = delete;
  OnCore& operator=(const OnCore&) = delete;

 private:
  cpu_set_t before_{};
};

/// There and back between two threads; ns a hop.
template <class Queue>
double two_threads_ns() {
  const auto there = std::make_unique<Queue>(), back = std::make_unique<Queue>();
  RawSample sample;
  const OnCore here(0);
  std::thread echo([&] {
    const OnCore elsewhere(1);
    RawSample heard;
    for (int i = 0; i <= kBatch; ++i) {
      Queue::take(*there, heard);
      back->push(heard);
    }
  });
  there->push(sample);  // the other thread runs when this comes back
  Queue::take(*back, sample);
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kBatch; ++i) {
    there->push(sample);
    Queue::take(*back, sample);
  }
  const auto end = std::chrono::steady_clock::now();
  echo.join();
  return std::chrono::duration<double, std::nano>(end - start).count() / (2 * kBatch);
}

/// Alternates between the two; every iteration is one batch of each.
template <class OursNs, class FloorNs>
void compare(benchmark::State& state, const OursNs& ours_ns, const char* floor_name, const FloorNs& floor_ns) {
  std::vector<double> ours, floor;
  for (auto _ : state) {
    ours.push_back(ours_ns());
    floor.push_back(floor_ns());
  }
  state.counters["ours_ns"] = median(ours);
  state.counters[floor_name] = median(floor);
  state.counters["ratio"] = median(ours) / median(floor);
}

void BM_RingInOneThread(benchmark::State& state) {
  const auto ours = std::make_unique<Ours>();
  const auto boost = std::make_unique<Boost>();
  const std::size_t before = bench::allocations();
  one_thread_ns(*ours);
  if (bench::allocations() != before) return state.SkipWithError("allocated");
  compare(
      state, [&] { return one_thread_ns(*ours); }, "boost_ns", [&] { return one_thread_ns(*boost); });
}
BENCHMARK(BM_RingInOneThread)->UseRealTime();

void BM_RingBetweenThreads(benchmark::State& state) {
  compare(state, two_threads_ns<Ours>, "boost_ns", two_threads_ns<Boost>);
}
BENCHMARK(BM_RingBetweenThreads)->UseRealTime()->Iterations(60);

/// No thread of the daemon sleeps on a ring: a wake is a system call of the sensor thread. This is what it would take.
void BM_RingBetweenSleepers(benchmark::State& state) {
  compare(state, two_threads_ns<SleepingOurs>, "futex_ns", two_threads_ns<Futex>);
}
BENCHMARK(BM_RingBetweenSleepers)->UseRealTime()->Iterations(30);

}  // namespace
}  // namespace stillpoint

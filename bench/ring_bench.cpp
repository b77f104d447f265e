/// Our ring beside boost::lockfree::spsc_queue, interleaved in the same run so that both meet the same machine:
/// `build/release/bench/micro --benchmark_filter=Ring`. Counters: ns a hop of each (median of the batches), their
/// ratio.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <thread>

#include "bench/allocations.h"
#include "core/spsc_ring.h"
#include "core/types.h"

namespace stillpoint {
namespace {

constexpr std::size_t kCapacity = 1024;
constexpr int kBatch = 400;  // hops: short enough that most batches are not interrupted

struct Ours {
  SpscRing<RawSample, kCapacity> ring;
  bool push(const RawSample& sample) { return ring.try_push(sample); }
  bool pop(RawSample& sample) { return ring.try_pop(sample); }
};

struct Boost {
  boost::lockfree::spsc_queue<RawSample, boost::lockfree::capacity<kCapacity>> ring;
  bool push(const RawSample& sample) { return ring.push(sample); }
  bool pop(RawSample& sample) { return ring.pop(sample) == 1; }
};

/// Until the queue gives one. A core that is shared must let the other thread run.
template <class Queue>
void take(Queue& queue, RawSample& sample) {
  for (int misses = 0; !queue.pop(sample); ++misses)
    if (misses > 10'000) std::this_thread::yield();
}

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

/// There and back between two threads that poll; ns a hop.
template <class Queue>
double two_threads_ns() {
  const auto there = std::make_unique<Queue>(), back = std::make_unique<Queue>();
  RawSample sample;
  std::thread echo([&] {
    RawSample heard;
    for (int i = 0; i <= kBatch; ++i) {
      take(*there, heard);
      back->push(heard);
    }
  });
  there->push(sample);  // the other thread runs when this comes back
  take(*back, sample);
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kBatch; ++i) {
    there->push(sample);
    take(*back, sample);
  }
  const auto end = std::chrono::steady_clock::now();
  echo.join();
  return std::chrono::duration<double, std::nano>(end - start).count() / (2 * kBatch);
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Alternates between the two; every iteration is one batch of each.
template <class OursNs, class BoostNs>
void compare(benchmark::State& state, const OursNs& ours_ns, const BoostNs& boost_ns) {
  std::vector<double> ours, boost;
  for (auto _ : state) {
    ours.push_back(ours_ns());
    boost.push_back(boost_ns());
  }
  state.counters["ours_ns"] = median(ours);
  state.counters["boost_ns"] = median(boost);
  state.counters["ratio"] = median(ours) / median(boost);
}

void BM_RingInOneThread(benchmark::State& state) {
  const auto ours = std::make_unique<Ours>();
  const auto boost = std::make_unique<Boost>();
  const std::size_t before = bench::allocations();
  one_thread_ns(*ours);
  if (bench::allocations() != before) return state.SkipWithError("allocated");
  compare(
      state, [&] { return one_thread_ns(*ours); }, [&] { return one_thread_ns(*boost); });
}
BENCHMARK(BM_RingInOneThread)->UseRealTime();

void BM_RingBetweenThreads(benchmark::State& state) { compare(state, two_threads_ns<Ours>, two_threads_ns<Boost>); }
BENCHMARK(BM_RingBetweenThreads)->UseRealTime()->Iterations(60);

}  // namespace
}  // namespace stillpoint

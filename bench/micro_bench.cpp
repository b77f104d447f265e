/// What one call of each building block costs: `build/release/bench/micro`. Every result carries its count of
/// allocations, and a building block of the sensor thread that allocates fails its benchmark.
#include <benchmark/benchmark.h>

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cmath>
#include <random>
#include <thread>

#include "bench/allocations.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "core/snapshot_cell.h"
#include "core/spsc_ring.h"
#include "fusion/attitude_filter.h"
#include "io/recording.h"

namespace stillpoint {
namespace {

constexpr std::size_t kSamples = 8192;
constexpr unsigned kSeed = 1;

/// A hand that moves for five seconds and rests for five, at 200 Hz, with consumer-grade noise.
std::vector<RawSample> samples() {
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  std::vector<RawSample> out(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double t_s = 0.005 * static_cast<double>(i);
    const double moving = std::fmod(t_s, 10.0) < 5.0 ? 1.0 : 0.0;
    RawSample& s = out[i];
    s.t_ns = static_cast<std::int64_t>(i) * 5'000'000;
    s.sequence = i;
    s.has = kAcc | kGyr | kMag | kTemp;
    s.temp_degC = 25.0;
    for (std::size_t k = 0; k < 3; ++k) {
      s.gyr_radps[k] = moving * std::sin(3.0 * t_s + static_cast<double>(k)) + 0.002 * normal(random);
      s.acc_mps2[k] = (k == 2 ? 9.81 : 0.0) + moving * std::cos(5.0 * t_s) + 0.02 * normal(random);
      s.mag_uT[k] = (k == 2 ? -43.0 : 20.0) + 0.3 * normal(random);
    }
  }
  return out;
}

/// Runs `step(i)` for i = 0.. and reports items and allocations; `realtime` ones must not allocate.
template <class Step>
void measure(benchmark::State& state, Step&& step, bool realtime = true) {
  std::size_t i = 0;
  const std::size_t before = bench::allocations();
  for (auto _ : state) step(i++);
  const std::size_t made = bench::allocations() - before;
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()));
  state.counters["allocs"] = static_cast<double>(made);
  if (realtime && made != 0) state.SkipWithError("allocated");
}

void BM_RingHop(benchmark::State& state) {
  const auto input = samples();
  SpscRing<RawSample, 1024> ring;
  measure(state, [&](std::size_t i) {
    ring.try_push(input[i % kSamples]);
    auto out = ring.try_pop();
    benchmark::DoNotOptimize(out);
  });
}
BENCHMARK(BM_RingHop);

void BM_RingHopBoost(benchmark::State& state) {
  const auto input = samples();
  boost::lockfree::spsc_queue<RawSample, boost::lockfree::capacity<1024>> ring;
  measure(state, [&](std::size_t i) {
    ring.push(input[i % kSamples]);
    RawSample out;
    ring.pop(out);
    benchmark::DoNotOptimize(out);
  });
}
BENCHMARK(BM_RingHopBoost);

/// There and back between two threads that poll; one item is one hop.
template <class Ring, class Push, class Pop>
void ping_pong(benchmark::State& state, Push push, Pop pop) {
  Ring there, back;
  std::atomic<bool> stop{false};
  std::thread echo([&] {
    RawSample sample;
    while (!stop.load(std::memory_order_relaxed))
      if (pop(there, sample)) push(back, sample);
  });
  RawSample sample;
  for (auto _ : state) {
    push(there, sample);
    while (!pop(back, sample)) {
    }
  }
  stop = true;
  echo.join();
  state.SetItemsProcessed(2 * static_cast<std::int64_t>(state.iterations()));
}

void BM_RingBetweenThreads(benchmark::State& state) {
  ping_pong<SpscRing<RawSample, 1024>>(
      state, [](auto& ring, const RawSample& s) { ring.try_push(s); },
      [](auto& ring, RawSample& s) {
        const auto taken = ring.try_pop();
        if (taken) s = *taken;
        return taken.has_value();
      });
}
BENCHMARK(BM_RingBetweenThreads)->UseRealTime();

void BM_RingBetweenThreadsBoost(benchmark::State& state) {
  ping_pong<boost::lockfree::spsc_queue<RawSample, boost::lockfree::capacity<1024>>>(
      state, [](auto& ring, const RawSample& s) { ring.push(s); },
      [](auto& ring, RawSample& s) { return ring.pop(s) == 1; });
}
BENCHMARK(BM_RingBetweenThreadsBoost)->UseRealTime();

void BM_SnapshotLoad(benchmark::State& state) {
  SnapshotCell<CalibrationSnapshot> cell;
  cell.store({});
  measure(state, [&](std::size_t) {
    auto out = cell.try_load();
    benchmark::DoNotOptimize(out);
  });
}
BENCHMARK(BM_SnapshotLoad);

void BM_SnapshotVersion(benchmark::State& state) {
  SnapshotCell<CalibrationSnapshot> cell;
  cell.store({});
  measure(state, [&](std::size_t) { benchmark::DoNotOptimize(cell.version()); });
}
BENCHMARK(BM_SnapshotVersion);

void BM_Correct(benchmark::State& state) {
  const auto input = samples();
  const CalibrationSnapshot snapshot;
  measure(state, [&](std::size_t i) {
    Vec3 u = snapshot.acc.apply(input[i % kSamples].acc_mps2, 25.0);
    benchmark::DoNotOptimize(u);
  });
}
BENCHMARK(BM_Correct);

void BM_RestDetector(benchmark::State& state) {
  auto input = samples();
  const CalibrationSnapshot snapshot;
  calib::RestDetector detector;
  std::int64_t lap_ns = 0;
  measure(state, [&](std::size_t i) {
    RawSample s = input[i % kSamples];
    if (i != 0 && i % kSamples == 0) lap_ns += static_cast<std::int64_t>(kSamples) * 5'000'000;
    s.t_ns += lap_ns;
    auto window = detector.push(s, snapshot);
    benchmark::DoNotOptimize(window);
  });
}
BENCHMARK(BM_RestDetector);

CalibratedSample calibrated(const RawSample& raw) {
  CalibratedSample s;
  s.t_ns = raw.t_ns;
  s.sequence = raw.sequence;
  s.acc_mps2 = raw.acc_mps2;
  s.gyr_radps = raw.gyr_radps;
  s.mag_uT = raw.mag_uT;
  s.temp_degC = raw.temp_degC;
  s.has = raw.has;
  return s;
}

void BM_AttitudeFilter(benchmark::State& state) {
  const auto input = samples();
  fusion::AttitudeFilter filter;
  measure(state, [&](std::size_t i) {
    CalibratedSample s = calibrated(input[i % kSamples]);
    s.t_ns = static_cast<std::int64_t>(i) * 5'000'000;
    auto estimate = filter.step(s, false);
    benchmark::DoNotOptimize(estimate);
  });
}
BENCHMARK(BM_AttitudeFilter);

void BM_AbsorbWindow(benchmark::State& state) {
  const CalibrationSnapshot factory;
  calib::RestDetector detector;
  std::vector<calib::Window> windows;
  for (const RawSample& s : samples())
    if (const auto w = detector.push(s, factory)) windows.push_back(*w);
  if (windows.empty()) return state.SkipWithError("no rest window in the input");
  calib::OnlineCalibrator calibrator({}, factory);
  measure(state, [&](std::size_t i) {
    calib::Window w = windows[i % windows.size()];
    w.t_start_ns += static_cast<std::int64_t>(i) * 2'000'000'000;
    w.t_end_ns += static_cast<std::int64_t>(i) * 2'000'000'000;
    benchmark::DoNotOptimize(calibrator.absorb(w));
  });
}
BENCHMARK(BM_AbsorbWindow);

void BM_ReadCsvRow(benchmark::State& state) {
  constexpr std::int64_t kRows = 20'000;
  std::string text =
      "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps,mag_x_uT,mag_y_uT,mag_z_uT\n";
  for (std::int64_t i = 0; i < kRows; ++i)
    text += std::to_string(i) + ".005,-0.2362,-0.3632,9.9193,-0.00106,-0.00426,0.00533,0.223,15.822,-38.338\n";
  for (auto _ : state) {
    auto recording = io::parse_recording(text, "bench.csv");
    benchmark::DoNotOptimize(recording);
  }
  state.SetItemsProcessed(kRows * static_cast<std::int64_t>(state.iterations()));
}
BENCHMARK(BM_ReadCsvRow)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace stillpoint

BENCHMARK_MAIN();

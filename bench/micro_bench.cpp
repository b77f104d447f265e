/// What one call of each building block costs: `build/release/bench/micro`. Every result carries its count of
/// allocations, and a building block of the sensor thread that allocates fails its benchmark.
#include <benchmark/benchmark.h>

#include "bench/allocations.h"
#include "bench/hand_samples.h"
#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "core/snapshot_cell.h"
#include "fusion/attitude_filter.h"
#include "io/recording.h"

namespace stillpoint {
namespace {

constexpr std::size_t kSamples = 8192;

std::vector<RawSample> samples() { return bench::hand_samples(kSamples, 200.0); }

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

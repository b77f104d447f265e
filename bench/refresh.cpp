/// `bench/refresh [--repeats N] [--seconds S]`: whether learning delays samples. The sensor thread at 1 kHz beside a
/// calibration thread that does its usual work, and beside one that solves all the time; interleaved, medians of the
/// repeats.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <thread>

#include "bench/arguments.h"
#include "bench/hand_samples.h"
#include "pipeline/calibration_loop.h"
#include "pipeline/realtime.h"
#include "pipeline/sources.h"

namespace stillpoint::bench {
namespace {

constexpr double kRate_hz = 1000.0;

struct NoSink {
  bool publish(const AttitudeMessage&) noexcept { return true; }
};
struct NoObserver {
  void on_sample(const pipeline::Outgoing&) {}
  void on_calibration(const pipeline::Evidence&, const CalibrationSnapshot&) {}
  void on_tick(const pipeline::SensorReport&, std::int64_t) {}
};

/// Rest windows of the input, learnt again and again, each time with a fresh snapshot, until asked to stop.
void solve_until(const std::atomic<bool>& stop, const std::vector<calib::Window>& windows) {
  calib::OnlineCalibrator calibrator({}, {});
  std::int64_t lap_ns = 0;
  while (!stop.load(std::memory_order_relaxed)) {
    for (calib::Window window : windows) {
      window.t_start_ns += lap_ns;
      window.t_end_ns += lap_ns;
      calibrator.absorb(window);
    }
    lap_ns += windows.back().t_end_ns;
  }
}

std::vector<calib::Window> windows_of(const std::vector<RawSample>& samples) {
  calib::RestDetector detector;
  std::vector<calib::Window> out;
  for (const RawSample& sample : samples)
    if (const auto window = detector.push(sample, CalibrationSnapshot{})) out.push_back(*window);
  return out;
}

void prepare(const char* name, int core, int priority) {
  for (const auto& refused : pipeline::prepare_thread(name, core, priority)) fmt::print(stderr, "{}\n", refused);
}

struct Tail {
  double p50_us = 0.0, p99_us = 0.0;
};

/// Time from a sample to its attitude in the sensor thread.
Tail run(const std::vector<RawSample>& samples, const std::vector<calib::Window>& windows, bool solving) {
  const auto shared = std::make_unique<pipeline::Shared>();
  calib::OnlineCalibrator calibrator({}, {});
  pipeline::PacedSource source(pipeline::MemorySource(samples), 1.0);
  pipeline::Stages stages({}, calibrator.snapshot());
  NoSink sink;
  NoObserver observer;
  pipeline::SensorLoop<decltype(source), NoSink> sensor(source, stages, sink, *shared, pipeline::OnLateAnswer::kGoOn,
                                                        pipeline::ThreadParams{}.rehearse_ahead_s);
  pipeline::CalibrationLoop<NoObserver> calibration(calibrator, *shared, observer, 0.002);
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const int other = cores > 1 ? 1 : 0;
  std::atomic<bool> stop{false};
  std::thread solver([&] {
    prepare("solver", other, 0);
    if (solving) solve_until(stop, windows);
  });
  std::thread slow([&] {
    prepare("calibration", other, 0);
    calibration.run();
  });
  std::thread fast([&] {
    prepare("sensor", 0, 10);
    sensor.run(pipeline::AtEnd::kStop);
  });
  fast.join();
  stop = true;
  slow.join();
  solver.join();
  const LatencyCounts counts = shared->processing.counts();
  const auto us = [&](double p) { return 1e-3 * static_cast<double>(latency_percentile_ns(counts, p)); };
  return {us(0.5), us(0.99)};
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void compare(int repeats, double seconds) {
  const auto samples = hand_samples(static_cast<std::size_t>(kRate_hz * seconds), kRate_hz);
  const auto windows = windows_of(hand_samples(60'000, kRate_hz, 2));
  std::vector<double> p50, p99;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const Tail without = run(samples, windows, false), with = run(samples, windows, true);
    fmt::print("repeat {}  usual p50 {:6.2f} p99 {:6.2f} us   solving all the time p50 {:6.2f} p99 {:6.2f} us\n",
               repeat + 1, without.p50_us, without.p99_us, with.p50_us, with.p99_us);
    p50.push_back(with.p50_us / without.p50_us);
    p99.push_back(with.p99_us / without.p99_us);
  }
  fmt::print("ratio, median of {}: p50 {:.2f}, p99 {:.2f}\n", repeats, median(p50), median(p99));
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  int repeats = 5;
  double seconds = 10.0;
  CLI::App app{"Whether learning delays samples: the sensor thread at 1 kHz, with and without a thread that solves on"};
  app.add_option("--repeats", repeats)->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--seconds", seconds, "of each run")->check(CLI::Range(1.0, 3600.0))->capture_default_str();
  if (const auto end = stillpoint::bench::parse(app, argc, argv)) return *end;
  stillpoint::bench::compare(repeats, seconds);
}

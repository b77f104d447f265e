/// Speed of the simulator in rows of nine axes a second: `build/release/bench/simulation_bench`. The output escapes,
/// the motion is a hand's with rests, evaluated anew at every row.
#include <benchmark/benchmark.h>

#include "bench/allocations.h"
#include "simulation/effect_catalogue.h"
#include "simulation/simulator.h"

namespace stillpoint::sim {
namespace {

SimulationConfig plain() {
  SimulationConfig c;
  c.rate_hz = 200.0;
  c.accelerometer = TriadConfig{.noise_sd = 0.02};
  c.gyroscope = TriadConfig{.noise_sd = 0.001};
  c.magnetometer = TriadConfig{.noise_sd = 0.3};
  c.motion = MotionConfig{.kind = "hand", .duration_s = 1e4};
  return c;
}

/// Every entry of the catalogue at the lower end of its usual size.
SimulationConfig with_all_effects() {
  SimulationConfig c = plain();
  for (const auto& info : effect_catalogue()) {
    EffectConfig& e = c.effects.emplace_back();
    e.id = info.id;
    for (const auto& p : info.parameters)
      if (p.required)
        e.parameters[p.key].assign(static_cast<std::size_t>(p.count), p.key == "t0_s" ? 60.0 : p.typical_low);
  }
  return c;
}

void run(benchmark::State& state, const SimulationConfig& config) {
  const std::shared_ptr<const Motion> motion = make_motion(*config.motion, 1);
  auto simulator = std::make_unique<Simulator>(config, motion, 1);
  SimulatedSample row;
  std::size_t allocated = 0;
  for (auto _ : state) {
    const std::size_t before = stillpoint::bench::allocations();
    const bool more = simulator->next(row);
    benchmark::DoNotOptimize(row);
    allocated += stillpoint::bench::allocations() - before;
    if (more) continue;
    state.PauseTiming();
    simulator = std::make_unique<Simulator>(config, motion, 1);
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["allocs"] = static_cast<double>(allocated);
  if (allocated != 0) state.SkipWithError("a row was simulated with an allocation");
}

void BM_PlainModel(benchmark::State& state) { run(state, plain()); }
void BM_AllEffects(benchmark::State& state) { run(state, with_all_effects()); }

BENCHMARK(BM_PlainModel);
BENCHMARK(BM_AllEffects);

}  // namespace
}  // namespace stillpoint::sim

BENCHMARK_MAIN();

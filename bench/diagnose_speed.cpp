/// `bench/diagnose_speed`: what the diagnosis of a long recording costs: ten minutes at 200 Hz of our own simulator
/// with two effects, on one core. Prints processor seconds, peak memory and what was found; ends with 1 when it took
/// longer than `--below` or more memory than `--below-mb`.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include <cmath>

#include "bench/arguments.h"
#include "bench/processor_time.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/heap.h"
#include "io/simulated_recording.h"

namespace stillpoint::bench {
namespace {

sim::SimulationConfig baseline(const std::string& reference, double minutes) {
  sim::SimulationConfig s;
  s.rate_hz = 200.0;
  s.accelerometer = sim::TriadConfig{.noise_sd = 0.02};
  s.gyroscope = sim::TriadConfig{.noise_sd = 0.001};
  s.magnetometer = sim::TriadConfig{.noise_sd = 0.3};
  s.motion = sim::MotionConfig{};
  s.motion->duration_s = 60.0 * minutes;
  s.environment.temperature = {.kind = "warm_up", .rise_K = 10.0, .tau_s = 120.0};
  s.environment.current.kind = "steps";
  s.reference.kind = reference;
  return s;
}

double peak_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

int run(const std::string& reference, double minutes, double below_s, double below_MB) {
  const sim::SimulationConfig given = baseline(reference, minutes);
  sim::SimulationConfig truth = given;
  truth.effects.push_back(
      {.id = "gyr_temp_lin", .parameters = {{"k_radps_per_K", {1e-4, 3e-4, -2e-4}}}, .axes = {}, .window_s = {}});
  truth.effects.push_back(
      {.id = "mag_current", .parameters = {{"k_uT_per_A", {0.8, -0.5, 0.3}}}, .axes = {}, .window_s = {}});
  const io::Recording recording = io::to_recording(sim::simulate(truth, 1));
  const double before_s = processor_s();
  const diag::Answer answer = diag::diagnose(recording, given);
  const double cost_s = processor_s() - before_s;
  std::vector<std::string> names;
  for (const auto& f : answer.diagnosis.findings) names.push_back(f.effect);
  const double memory_MB = peak_MB();
  fmt::print("{:.0f} min at 200 Hz, {} reference: {:.1f} s of processor, {:.0f} MB at most; found: {}\n", minutes,
             reference, cost_s, memory_MB, fmt::join(names, ", "));
  return cost_s > below_s || memory_MB > below_MB ? 1 : 0;
}

}  // namespace
}  // namespace stillpoint::bench

int main(int argc, char** argv) {
  CLI::App app{"What the diagnosis of a long recording costs"};
  std::string reference = "mocap";
  double minutes = 10.0, below_s = HUGE_VAL, below_MB = HUGE_VAL;
  app.add_option("--reference", reference, "exact, mocap or none")->check(CLI::IsMember({"exact", "mocap", "none"}));
  app.add_option("--minutes", minutes, "length of the recording")->check(CLI::Range(1.0, 120.0));
  app.add_option("--below", below_s, "end with 1 when it takes more seconds of processor than this");
  app.add_option("--below-mb", below_MB, "end with 1 when it takes more megabytes than this");
  if (const auto end = stillpoint::bench::parse(app, argc, argv)) return *end;
  stillpoint::diag::keep_freed_memory();
  return stillpoint::bench::run(reference, minutes, below_s, below_MB);
}

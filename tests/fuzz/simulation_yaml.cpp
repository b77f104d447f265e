/// Simulations: faults, each at its place, or a configuration that writes a text which reads back, and that runs.
#include "io/simulation_yaml.h"

#include <cmath>

#include "simulation/simulator.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

namespace {

/// What the reader lets pass gives finite readings. The first rows of short motions: more would take its time.
void expect_runs(sim::SimulationConfig config) {
  constexpr double kLongest_s = 60.0, kFastest_hz = 50.0;
  if (!config.motion || config.motion->duration_s > kLongest_s) return;
  config.rate_hz = std::min(config.rate_hz, kFastest_hz);
  sim::Simulator simulator(config, sim::make_motion(*config.motion, 1), 1);
  sim::SimulatedSample row;
  for (int k = 0; k < 20 && simulator.next(row); ++k)
    for (const auto slot : {&RawSample::acc_mps2, &RawSample::gyr_radps, &RawSample::mag_uT})
      fuzz::expect(vec(row.sample.*slot).allFinite(), "a simulated reading is finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto config = io::parse_simulation(std::string(fuzz::text(data, size)), "f.yaml");
  if (!config) {
    fuzz::expect(config.error().message.starts_with("f.yaml:"), "a fault names its file", config.error().message);
    return 0;
  }
  fuzz::taken();
  const std::string written = io::format_simulation(*config);
  const auto again = io::parse_simulation(written, "g.yaml");
  fuzz::expect(again.has_value(), "what was written reads back", again ? "" : again.error().message);
  fuzz::expect(io::format_simulation(*again) == written, "what was written means the same", written);
  expect_runs(std::move(*config));
  return 0;
}

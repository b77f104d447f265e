/// Samples of a simulated sensor in the hand (configs/sim_handheld.yaml), shared by the tests of the pipeline.
#pragma once
#include <stdexcept>
#include <vector>

#include "io/simulation_yaml.h"
#include "simulation/simulator.h"
#include "tests/source_folder.h"

namespace stillpoint::test {

inline std::vector<RawSample> hand_samples(double seconds, std::uint64_t seed = 1) {
  auto config = io::read_simulation(in_source("configs/sim_handheld.yaml"));
  if (!config) throw std::runtime_error(config.error().message);
  config->motion->duration_s = seconds;
  std::vector<RawSample> samples;
  for (const auto& row : sim::simulate(*config, seed)) samples.push_back(row.sample);
  return samples;
}

}  // namespace stillpoint::test

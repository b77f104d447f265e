/// A simulated sensor through all stages with their own calibrator, as `estimate` runs them, against the truth.
#pragma once
#include "core/result.h"
#include "core/so3.h"
#include "io/simulation_yaml.h"
#include "pipeline/stages.h"
#include "simulation/simulator.h"
#include "tests/fusion/random_motion.h"

namespace stillpoint::test {

/// `each(truth, processed, stages)` after every sample. `spoil(sample)` may change the reading before; false: it never
/// came.
template <class Spoil, class Each>
void run_spoiled(const std::string& simulation_yaml, const pipeline::StagesParams& params, std::uint64_t seed,
                 const Spoil& spoil, const Each& each) {
  const auto simulation = io::parse_simulation(simulation_yaml, "test");
  SP_EXPECTS(simulation.has_value());
  sim::Simulator simulator(*simulation, sim::make_motion(*simulation->motion, seed), seed);
  calib::OnlineCalibrator calibrator({}, {});
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(params, calibrator.snapshot());
  pipeline::Processed out;
  for (sim::SimulatedSample s; simulator.next(s);)
    if (spoil(s.sample) && stages.process(s.sample, out, link) != pipeline::StageStatus::kDrop) each(s, out, stages);
}

/// `each(truth, processed)` after every sample.
template <class Each>
void run_simulated(const std::string& simulation_yaml, const pipeline::StagesParams& params, std::uint64_t seed,
                   const Each& each) {
  run_spoiled(
      simulation_yaml, params, seed, [](const RawSample&) { return true; },
      [&each](const sim::SimulatedSample& truth, const pipeline::Processed& out, const pipeline::Stages&) {
        each(truth, out);
      });
}

/// Rotation in the world from the estimate to the truth [rad].
inline Vec3 world_error(const sim::SimulatedSample& truth, const pipeline::Processed& estimate) {
  return error_world(truth.true_q_world_body, quat(estimate.attitude.q_world_body));
}

}  // namespace stillpoint::test

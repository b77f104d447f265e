/// `stillpoint simulate`: the recording a simulated sensor would give, and what was applied to it.
#include "apps/stillpoint/commands.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"

namespace stillpoint::app {
namespace {

struct Options {
  std::string simulation, output, truth, motion;
  std::uint64_t seed = 1;
};

int simulate(const Options& o) {
  const auto config = io::read_simulation(o.simulation);
  if (!config) return report(config.error());
  if (!config->motion)
    return report({ErrorKind::kBadConfig, o.simulation +
                                              ":1:1: no 'motion:' block; add one such as "
                                              "motion: {kind: hand, duration_s: 130}, or give --motion REC.csv"});
  const auto recording = io::to_recording(sim::simulate(*config, o.seed));
  if (const auto written = io::write_recording(recording, o.output); !written) return report(written.error());
  return 0;
}

}  // namespace

void add_simulate(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("simulate", "Write the recording a simulated sensor would give");
  static Options o;
  command->add_option("--simulation", o.simulation, "simulation YAML")->required();
  command->add_option("--output", o.output, "recording to write (.csv)")->required();
  command->add_option("--seed", o.seed, "seed of all random streams");
  command->callback([&run] { run = [] { return simulate(o); }; });
}

}  // namespace stillpoint::app

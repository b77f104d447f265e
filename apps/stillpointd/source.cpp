#include "apps/stillpointd/source.h"

#include "apps/stillpointd/log.h"
#include "io/recording.h"
#include "io/simulation_yaml.h"

namespace stillpoint::app {
namespace {

Result<AnySource> open_recording(const std::string& path) {
  const auto recording = io::read_recording(path);
  if (!recording) return tl::unexpected(recording.error());
  for (const auto& line : io::describe(recording->issues)) log(path + ": " + line);
  std::vector<RawSample> samples(recording->size());
  for (std::size_t row = 0; row < samples.size(); ++row) samples[row] = recording->sample(row);
  return AnySource(pipeline::MemorySource(std::move(samples)));
}

Result<AnySource> open_simulation(const std::string& path, int seed) {
  const auto simulation = io::read_simulation(path);
  if (!simulation) return tl::unexpected(simulation.error());
  if (!simulation->motion)
    return fail(ErrorKind::kBadConfig,
                path + ": no 'motion:' block; add one such as motion: {kind: hand, duration_s: 130}");
  const auto stream = static_cast<std::uint64_t>(seed);
  return AnySource(SimulatorSource(sim::Simulator(
      *simulation, std::shared_ptr<const sim::Motion>(sim::make_motion(*simulation->motion, stream)), stream)));
}

}  // namespace

Result<DaemonSource> open_source(const io::SourceConfig& config) {
  auto source = config.kind == io::SourceKind::kSimulation ? open_simulation(config.file, config.seed)
                                                           : open_recording(config.file);
  if (!source) return tl::unexpected(source.error());
  return DaemonSource(pipeline::PacedSource<AnySource>(std::move(*source), config.speed),
                      config.faults.value_or(pipeline::FaultParams{}));
}

}  // namespace stillpoint::app

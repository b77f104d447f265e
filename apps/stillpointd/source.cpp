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

/// A live source, with what it has to tell.
template <class Source>
Result<AnySource> live(Result<Source> source, const io::SourceConfig& config) {
  if (!source) return fail(source.error().kind, config.place + ": " + source.error().message);
  sources::ReportCell report = source->report();
  return AnySource(std::move(*source), std::move(report));
}

Result<AnySource> open_any(const io::DaemonConfig& config) {
  const io::SourceConfig& source = config.source;
  switch (source.kind) {
    case io::SourceKind::kStream:
      return live(sources::StreamSource::create(source.stream, source.reopen_at_most_s), source);
    case io::SourceKind::kRos2:
      return live(sources::Ros2Source::create(source.ros2, config.dds), source);
    case io::SourceKind::kIio:
      return live(Result<sources::IioSource>(sources::IioSource(source.iio, source.reopen_at_most_s)), source);
    case io::SourceKind::kSimulation:
      return open_simulation(source.file, source.seed);
    default:
      return open_recording(source.file);
  }
}

}  // namespace

Result<DaemonSource> open_source(const io::DaemonConfig& config) {
  auto source = open_any(config);
  if (!source) return tl::unexpected(source.error());
  return DaemonSource(std::move(*source), config.source);
}

}  // namespace stillpoint::app

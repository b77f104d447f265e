#include "apps/stillpoint/demo_stage.h"

#include <fmt/format.h>

#include "io/dds_domain.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"
#include "simulation/simulator.h"

namespace stillpoint::app {
namespace {

/// The configurations of the installation that this program belongs to, else of the source it was built from.
std::filesystem::path configs_folder() {
  const auto installed = program_folder() / "../share/stillpoint/configs";
  return std::filesystem::exists(installed) ? installed : std::filesystem::path(STILLPOINT_SOURCE "/configs");
}

}  // namespace

std::filesystem::path program_folder() { return std::filesystem::read_symlink("/proc/self/exe").parent_path(); }

Result<DemoStage> prepare_stage(const DemoOptions& options) {
  std::error_code code;
  std::filesystem::create_directories(options.folder, code);
  if (code)
    return fail(ErrorKind::kCannotCreate, fmt::format("{}: cannot be created: {}", options.folder, code.message()));
  auto simulation = io::read_simulation(configs_folder() / "sim_handheld.yaml");
  if (!simulation) return tl::unexpected(simulation.error());
  DemoStage stage;
  stage.recording = io::to_recording(sim::simulate(*simulation, static_cast<std::uint64_t>(options.seed)));
  stage.recording.header["source"] = "stillpoint demo";
  stage.duration_s = stage.recording.t_s(stage.recording.size() - 1) - stage.recording.t_s(0);
  stage.dds.domain = options.domain >= 0 ? options.domain : io::own_domain();
  stage.config_path = options.folder + "/stillpointd.yaml";
  const std::string config = fmt::format(
      "# The demo's daemon: replays the recording beside it at {:.3g} times real time, knowing nothing of the sensor.\n"
      "source: {{kind: recording, file: recording.csv, speed: {:.9g}}}\nsensor: {{id: demo}}\ndds: {{domain: {}}}\n",
      stage.duration_s / options.seconds, stage.duration_s / options.seconds, stage.dds.domain);
  if (auto r = io::write_recording(stage.recording, options.folder + "/recording.csv"); !r)
    return tl::unexpected(r.error());
  if (auto r = io::write_simulation(*simulation, options.folder + "/simulation.yaml"); !r)
    return tl::unexpected(r.error());
  simulation->effects.clear();
  if (auto r = io::write_simulation(*simulation, options.folder + "/simulation_without_effects.yaml"); !r)
    return tl::unexpected(r.error());
  if (auto r = io::write_text_file(stage.config_path, config); !r) return tl::unexpected(r.error());
  // What the daemon will read is what was written, rounded: the comparison uses the same.
  auto written = io::read_recording(options.folder + "/recording.csv");
  if (!written) return tl::unexpected(written.error());
  stage.recording = std::move(*written);
  return stage;
}

}  // namespace stillpoint::app

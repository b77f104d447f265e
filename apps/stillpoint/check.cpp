/// `stillpoint check FILE`: says what is wrong with a recording, a configuration or a simulation.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/plausible.h"
#include "io/config.h"
#include "io/recording.h"
#include "io/simulation_yaml.h"

namespace stillpoint::app {
namespace {

int check_recording(const std::string& path) {
  const auto recording = io::read_recording(path);
  if (!recording) return report(recording.error());
  std::printf("%s: %zu rows, %.1f s\n", path.c_str(), recording->size(),
              recording->t_s(recording->size() - 1) - recording->t_s(0));
  for (const auto& sensor : io::sensor_times(*recording)) {
    std::string line = fmt::format("{}: {}: {} readings", path, sensor.name, sensor.readings);
    if (sensor.median_step_s > 0.0) line += fmt::format(", {:.4g} Hz", 1.0 / sensor.median_step_s);
    if (sensor.gaps > 0) line += fmt::format(", {} gaps, the longest {:.3f} s", sensor.gaps, sensor.longest_gap_s);
    std::printf("%s\n", line.c_str());
  }
  for (const auto& line : io::describe(recording->issues)) std::printf("%s: %s\n", path.c_str(), line.c_str());
  return warn_if_implausible(*recording, path).empty() ? 0 : static_cast<int>(ErrorKind::kBadData);
}

/// A daemon's configuration and a simulation share no top-level key: the one that knows more of the keys is meant.
bool looks_like_simulation(const YAML::Node& root) {
  int votes = 0;
  const auto vote = [&](const auto&... f) { ((votes -= root[std::string(f.name)] ? 1 : 0), ...); };
  std::apply(vote, io::DaemonConfig::fields());
  for (const std::string& key : io::simulation_keys()) votes += root[key] ? 1 : 0;
  return votes > 0;
}

int check_yaml(const std::string& path) {
  const auto root = io::load_yaml(path);
  if (!root) return report(root.error());
  if (looks_like_simulation(*root)) {
    const auto simulation = io::read_simulation(path);
    if (!simulation) return report(simulation.error());
    std::printf("%s: a simulation without fault, %zu effects\n", path.c_str(), simulation->effects.size());
    return 0;
  }
  const auto config = io::read_config(path);
  if (!config) return report(config.error());
  std::printf("%s: a configuration without fault\n", path.c_str());
  return 0;
}

}  // namespace

void add_check(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("check", "Say what is wrong with a recording, a configuration or a simulation");
  static std::string path;
  command->add_option("FILE", path, "recording (.csv), configuration or simulation (.yaml)")->required();
  command->callback([&run] {
    run = [] { return path.ends_with(".yaml") || path.ends_with(".yml") ? check_yaml(path) : check_recording(path); };
  });
}

}  // namespace stillpoint::app

/// Simulation YAML (docs/formats.md) to sim::SimulationConfig and back.
#pragma once
#include <string>
#include <vector>

#include "core/result.h"
#include "io/yaml.h"
#include "simulation/config.h"

namespace stillpoint::io {

/// Every fault is named with file:line:column: unknown keys and effect IDs (with the nearest known one), missing or
/// surplus parameters, a wrong count of numbers, values out of range, sensors where the effect has no choice of them.
/// Exit codes 66 (no file), 78.
[[nodiscard]] Result<sim::SimulationConfig> read_simulation(const std::string& path);
[[nodiscard]] Result<sim::SimulationConfig> parse_simulation(const std::string& text, const std::string& name);

/// The keys of its top level.
[[nodiscard]] const std::vector<std::string>& simulation_keys();

/// One entry of an `effects:` or `compensate:` list: {effect: ID, parameters..., axes: [x],
/// sensors: [acc], window_s: [a, b]}.
void read_effect(const YAML::Node& entry, sim::EffectConfig& out, YamlFaults& faults);

/// One entry {effect: law, sensor: acc, law: "norm(w) * (T - 25)", k: [...]} or {effect: table, ...}.
void read_written_effect(const YAML::Node& entry, sim::EffectConfig& out, YamlFaults& faults);
[[nodiscard]] std::string format_written_effect(const sim::EffectConfig& effect);

/// Text that reads back to an equal configuration. Defaults are left out of the optional blocks.
[[nodiscard]] std::string format_simulation(const sim::SimulationConfig& config);
[[nodiscard]] std::string format_effect(const sim::EffectConfig& effect);  ///< one line, flow style
[[nodiscard]] std::string format_numbers(const sim::TriadConfig& triad);   ///< bias and matrix of such a line
[[nodiscard]] Result<void> write_simulation(const sim::SimulationConfig& config, const std::string& path);

}  // namespace stillpoint::io

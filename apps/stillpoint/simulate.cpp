/// `stillpoint simulate`: the recording a simulated sensor would give, and the truth of what was applied to it.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "core/units.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "io/text_file.h"
#include "simulation/law_effect.h"
#include "simulation/strength.h"

namespace stillpoint::app {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kMostRows = 2e7;  // 24 h at 200 Hz are 1.7e7; each row takes about 250 bytes of disk

struct SimulateOptions {
  std::string simulation, output, truth, motion;
  std::uint64_t seed = 1;
};

struct Scene {
  std::shared_ptr<const sim::Motion> motion;
  sim::RecordedEnvironment environment;
};

Result<Scene> scene_of(const SimulateOptions& o, const sim::SimulationConfig& config) {
  if (o.motion.empty() && !config.motion)
    return fail(ErrorKind::kBadConfig, o.simulation +
                                           ":1:1: no 'motion:' block; add one such as motion: {kind: hand, "
                                           "duration_s: 130}, or give --motion REC.csv");
  if (const auto columns = sim::user_columns_of(config.effects); o.motion.empty() && !columns.empty())
    return fail(ErrorKind::kBadConfig,
                fmt::format("{}:1:1: a law needs the column '{}'; give --motion REC.csv that has it", o.simulation,
                            columns.front()));
  if (o.motion.empty()) return Scene{sim::make_motion(*config.motion, o.seed), {}};
  const auto recording = io::read_recording(o.motion);
  if (!recording) return tl::unexpected(recording.error());
  auto motion = sim::RecordedMotion::from(io::reference_track(*recording));
  if (!motion) return fail(motion.error().kind, o.motion + ": " + motion.error().message);
  auto environment = io::recorded_environment(*recording);
  for (const std::string& name : sim::user_columns_of(config.effects))
    if (!environment.user.contains(name))
      return fail(ErrorKind::kBadData,
                  fmt::format("{}: a law needs its column '{}', which is not there", o.motion, name));
  return Scene{std::move(*motion), std::move(environment)};
}

Json triad_json(const std::optional<sim::TriadConfig>& t) {
  if (!t) return nullptr;
  return {{"bias", array(t->bias)}, {"matrix", array(t->matrix)}, {"noise_sd", t->noise_sd}};
}

Json effect_json(const sim::EffectConfig& e, const sim::EffectStrength& s) {
  Json out{{"effect", e.id}};
  for (const auto& [key, values] : e.parameters)
    out["parameters"][key] = values.size() == 1 ? Json(values[0]) : Json(values);
  if (!e.axes.empty()) out["axes"] = e.axes;
  for (const sim::Sensor sensor : e.sensors) out["sensors"].push_back(sim::prefix(sensor));
  if (e.window_s) out["window_s"] = {e.window_s->first, e.window_s->second};
  for (const sim::Sensor sensor : sim::kSensors) {
    const auto& strength = s.sensor[static_cast<std::size_t>(sensor)];
    out["strength"][sim::prefix(sensor)] = {{"rms_over_noise", strength.rms_over_noise}, {"d_prime", strength.d_prime}};
  }
  return out;
}

/// Writes the recording; gives the spans in which the body moved.
Result<Json> write_simulated(const SimulateOptions& o, const sim::SimulationConfig& config, const Scene& scene) {
  Json bouts = Json::array();
  auto file = io::SimulatedRecordingFile::create(o.output, config);
  if (!file) return tl::unexpected(file.error());
  sim::Simulator simulator(config, scene.motion, o.seed, scene.environment);
  bool moved = false;
  double since_s = 0.0, t_s = 0.0;
  for (sim::SimulatedSample row; simulator.next(row);) {
    if (simulator.outside_table())
      return fail(
          ErrorKind::kBadConfig,
          fmt::format("{}:1:1: at {:.3f} s a table's driver is outside the range of its 'x'; widen the table, or "
                      "write 'clamp: true' into it",
                      o.simulation, in_seconds(row.sample.t_ns)));
    if (auto done = file->add(row); !done) return tl::unexpected(done.error());
    t_s = in_seconds(row.sample.t_ns);
    if (row.moving && !moved) since_s = t_s;
    if (!row.moving && moved) bouts.push_back({since_s, t_s});
    moved = row.moving;
  }
  if (moved) bouts.push_back({since_s, t_s});
  if (auto done = file->finish(); !done) return tl::unexpected(done.error());
  return bouts;
}

int write_truth(const SimulateOptions& o, const sim::SimulationConfig& config, const Scene& scene, const Json& bouts) {
  const auto strengths = sim::effect_strengths(config, scene.motion, o.seed, scene.environment);
  Json truth{{"schema", "stillpoint.truth/1"}, {"seed", o.seed}, {"reference", config.reference.kind}};
  truth["effects"] = Json::array();
  for (std::size_t k = 0; k < strengths.size(); ++k)
    truth["effects"].push_back(effect_json(config.effects[k], strengths[k]));
  truth["accelerometer"] = triad_json(config.accelerometer);
  truth["gyroscope"] = triad_json(config.gyroscope);
  truth["magnetometer"] = triad_json(config.magnetometer);
  truth["gravity_mps2"] = config.gravity_mps2;
  truth["field_world_uT"] = array(config.field_world_uT);
  truth["bouts"] = bouts;
  truth["simulation"] = io::format_simulation(config);
  const auto written = io::write_text_file(o.truth, json_text(truth, 1));
  return written ? 0 : report(written.error());
}

int simulate(const SimulateOptions& o) {
  if (const auto taken = is_standard_output({o.output, o.truth}); !taken) return report(taken.error());
  if (const auto writable = io::expect_writable(o.truth); !writable) return report(writable.error());
  auto config = io::read_simulation(o.simulation);
  if (!config) return report(config.error());
  if (!o.motion.empty()) config->motion.reset();
  const auto too_many = [&](double duration_s) {
    return duration_s * config->rate_hz > kMostRows
               ? report({ErrorKind::kBadConfig,
                         fmt::format("{}:1:1: {} s at {} Hz are more than the {} rows a recording may have; lower "
                                     "duration_s or rate_hz",
                                     o.simulation, duration_s, config->rate_hz, kMostRows)})
               : 0;
  };
  if (config->motion)
    if (const int code = too_many(config->motion->duration_s)) return code;
  const auto scene = scene_of(o, *config);
  if (!scene) return report(scene.error());
  if (!config->motion)
    if (const int code = too_many(scene->motion->duration_s())) return code;
  const auto bouts = write_simulated(o, *config, *scene);
  if (!bouts) return report(bouts.error());
  return o.truth.empty() ? 0 : write_truth(o, *config, *scene, *bouts);
}

}  // namespace

void add_simulate(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("simulate", "Write the recording a simulated sensor would give");
  static SimulateOptions o;
  add_file(*command, "--simulation", o.simulation, "simulation YAML")->required();
  add_file(*command, "--output", o.output, "recording to write (.csv); - is standard output")->required();
  add_file(*command, "--truth", o.truth, "write what was applied, with the strength of each effect (.json)");
  command->add_option("--seed", o.seed, "seed of all random streams; 1 unless given")->check(between(0.0, 9e15));
  add_file(*command, "--motion", o.motion, "take motion and surroundings from this recording's columns (.csv)");
  command->callback([&run] { run = [] { return simulate(o); }; });
}

}  // namespace stillpoint::app

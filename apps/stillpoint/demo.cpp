/// `stillpoint demo`: the whole product in under a minute and without a sensor. A simulated hand-held sensor is
/// recorded, the daemon replays it in its own process, this process subscribes over DDS, shows the attitude live, and
/// compares it with the truth, with and without self-calibration.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/stillpoint/child_process.h"
#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/dds_options.h"
#include "apps/stillpoint/demo_score.h"
#include "apps/stillpoint/watch_model.h"
#include "core/units.h"
#include "io/config.h"
#include "io/dds_subscriber.h"
#include "io/recording.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "pipeline/stages.h"
#include "simulation/simulator.h"

namespace stillpoint::app {
namespace {

using Clock = std::chrono::steady_clock;

struct DemoOptions {
  double seconds = 30.0;
  std::string folder = "demo-out";
  int seed = 1;
  int domain = -1;
  bool json = false;
};

/// What is simulated, where it lies and how fast it is replayed.
struct Stage {
  io::Recording recording;
  std::string config_path;
  io::DdsParams dds;
  double duration_s = 0.0;
};

/// A domain of its own, so that no other daemon of this machine is seen: 1 to 100, as the ports of higher ones may be
/// taken by any connection.
int own_domain() { return 1 + static_cast<int>(getpid() % 100); }

Result<void> write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file)
    return fail(ErrorKind::kCannotCreate, path + ": cannot be written; is the folder yours and the disk not full?");
  return {};
}

std::filesystem::path program_folder() { return std::filesystem::read_symlink("/proc/self/exe").parent_path(); }

/// The configurations of the installation that this program belongs to, else of the source it was built from.
std::filesystem::path configs_folder() {
  const auto installed = program_folder() / "../share/stillpoint/configs";
  return std::filesystem::exists(installed) ? installed : std::filesystem::path(STILLPOINT_SOURCE "/configs");
}

/// Simulates, and writes into the folder: the recording, the simulation, the same without its effects, and the daemon's
/// configuration.
Result<Stage> prepare(const DemoOptions& options) {
  std::error_code code;
  std::filesystem::create_directories(options.folder, code);
  if (code)
    return fail(ErrorKind::kCannotCreate, fmt::format("{}: cannot be created: {}", options.folder, code.message()));
  auto simulation = io::read_simulation(configs_folder() / "sim_handheld.yaml");
  if (!simulation) return tl::unexpected(simulation.error());
  Stage stage;
  stage.recording = io::to_recording(sim::simulate(*simulation, static_cast<std::uint64_t>(options.seed)));
  stage.recording.header["source"] = "stillpoint demo";
  stage.duration_s = stage.recording.t_s(stage.recording.size() - 1) - stage.recording.t_s(0);
  stage.dds.domain = options.domain >= 0 ? options.domain : own_domain();
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
  if (auto r = write_text(stage.config_path, config); !r) return tl::unexpected(r.error());
  // What the daemon will read is what was written, rounded: the comparison uses the same.
  auto written = io::read_recording(options.folder + "/recording.csv");
  if (!written) return tl::unexpected(written.error());
  stage.recording = std::move(*written);
  return stage;
}

std::size_t row_at(const io::Recording& r, std::int64_t t_ns) {
  const auto it = std::lower_bound(r.t_ns.begin(), r.t_ns.end(), t_ns);
  return it != r.t_ns.end() && *it == t_ns ? static_cast<std::size_t>(it - r.t_ns.begin()) : r.size();
}

Quat truth_at(const io::Recording& r, std::size_t row) {
  const Eigen::Vector4d& q = r.ref_q_world_body[row];
  return Quat(q[0], q[1], q[2], q[3]);
}

/// Counts the second half of the recording: the first half is the learning.
bool counts(const io::Recording& r, std::size_t row) { return row < r.size() && 2 * row >= r.size(); }

/// The same recording through the same stages, with nothing learnt: neither by the calibration nor by the filter.
AttitudeScore score_without_learning(const io::Recording& recording, const io::DaemonConfig& config) {
  pipeline::StagesParams params = io::stages_params(config);
  params.learn = false;
  params.attitude.gyr_bias_sd_radps = params.attitude.gyr_bias_walk_radps_rtHz = params.attitude.gyr_matrix_sd = 0.0;
  params.attitude.acc_bias_sd_mps2 = params.attitude.acc_bias_walk_mps2_rtHz = 0.0;
  calib::OnlineCalibrator calibrator(config.calibration.online, io::factory_calibration(config.sensor));
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(params, calibrator.snapshot());
  pipeline::Processed out;
  AttitudeScore score;
  for (std::size_t row = 0; row < recording.size(); ++row) {
    if (stages.process(recording.sample(row), out, link) == pipeline::StageStatus::kDrop) continue;
    const auto& q = out.attitude.q_world_body;
    if (counts(recording, row)) score.add(Quat(q[0], q[1], q[2], q[3]), truth_at(recording, row));
  }
  return score;
}

/// What the subscriber hears, and how far it is from the truth. Filled by a DDS thread.
struct Listener {
  const io::Recording& recording;
  WatchModel model;
  std::mutex mutex;
  AttitudeScore score;
  double present_error_rad = 0.0;
  double t_s = 0.0;

  void take(const AttitudeMessage& m, std::int64_t t_receive_ns) {
    model.take(m, t_receive_ns);
    const std::size_t row = row_at(recording, m.t_ns);
    if (row == recording.size() || m.status == AttitudeStatus::kStale) return;
    const auto& q = m.q_world_body_xyzw;
    const Quat attitude(q[3], q[0], q[1], q[2]);
    const std::scoped_lock lock(mutex);
    if (counts(recording, row)) score.add(attitude, truth_at(recording, row));
    present_error_rad = attitude.angularDistance(truth_at(recording, row));
    t_s = recording.t_s(row) - recording.t_s(0);
  }
};

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

void show(Listener& listener, const Stage& stage, bool terminal) {
  const WatchState state = listener.model.state(now_ns());
  double error_rad = 0.0, t_s = 0.0;
  {
    const std::scoped_lock lock(listener.mutex);
    error_rad = listener.present_error_rad;
    t_s = listener.t_s;
  }
  if (!terminal) {
    if (state.received > 0)
      fmt::print("t {:5.1f} s   error against the truth {:6.2f} deg   received {}   lost {}\n", t_s,
                 error_rad * kDegPerRad, state.received, state.lost);
    std::fflush(stdout);
    return;
  }
  constexpr int kBar = 40;
  const int done = static_cast<int>(kBar * t_s / stage.duration_s);
  fmt::print(
      "\033[H\033[2Jstillpoint demo: a simulated hand-held sensor, DDS domain {}, ENU, quaternion x y z w\n\n{}\n"
      "against the truth  {:.2f} deg\n[{:=<{}}>{: <{}}] {:.0f} of {:.0f} s\n",
      stage.dds.domain, state.received > 0 ? text_view(state) : "waiting for the daemon\n", error_rad * kDegPerRad, "",
      done, "", kBar - done, t_s, stage.duration_s);
  std::fflush(stdout);
}

/// Shows until the daemon has ended. Fails when it ended badly or does not end.
Result<void> follow(ChildProcess& daemon, Listener& listener, const Stage& stage, const DemoOptions& options) {
  constexpr double kPatience_s = 20.0;
  const bool terminal = !options.json && isatty(STDOUT_FILENO) != 0;
  const auto start = Clock::now();
  auto next_line = start;
  while (!daemon.ended()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto now = Clock::now();
    if (!options.json && now >= next_line) {
      show(listener, stage, terminal);
      next_line = now + (terminal ? std::chrono::milliseconds(200) : std::chrono::milliseconds(3000));
    }
    if (stop_asked()) return fail(ErrorKind::kUsage, "stopped by a signal");
    if (std::chrono::duration<double>(now - start).count() > options.seconds + kPatience_s)
      return fail(ErrorKind::kUnavailable,
                  "the daemon does not end; its words are in " + options.folder + "/stillpointd.log");
  }
  if (*daemon.ended() != 0)
    return fail(ErrorKind::kUnavailable,
                fmt::format("the daemon ended with code {}; its words are in {}/stillpointd.log", *daemon.ended(),
                            options.folder));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the last messages
  return {};
}

nlohmann::json to_json(const AttitudeScore& s) {
  return {{"total_rad", s.total_rad()},
          {"heading_rad", s.heading_rad()},
          {"inclination_rad", s.inclination_rad()},
          {"samples", s.count()}};
}

void print_end(const DemoOptions& options, const Stage& stage, const AttitudeScore& with, const AttitudeScore& without,
               const WatchState& state) {
  if (options.json) {
    const nlohmann::json out{{"schema", "stillpoint.demo/1"},
                             {"with_self_calibration", to_json(with)},
                             {"without_self_calibration", to_json(without)},
                             {"received", state.received},
                             {"lost", state.lost},
                             {"domain", stage.dds.domain},
                             {"seed", options.seed},
                             {"recording_s", stage.duration_s},
                             {"folder", options.folder}};
    fmt::print("{}\n", out.dump(2));
    return;
  }
  fmt::print(
      "\nattitude error without self-calibration {:.1f} deg, with {:.2f} deg (rms over the second half; heading "
      "{:.2f}, "
      "inclination {:.2f}; seed {})\n",
      without.total_rad() * kDegPerRad, with.total_rad() * kDegPerRad, with.heading_rad() * kDegPerRad,
      with.inclination_rad() * kDegPerRad, options.seed);
  fmt::print(
      "received {} attitudes over DDS, lost {}\nrecording {}/recording.csv\n\nnow try\n"
      "  stillpoint diagnose --simulation {}/simulation_without_effects.yaml --recording {}/recording.csv\n"
      "  stillpoint calibrate --recording {}/recording.csv\n"
      "  stillpointd --config {}/stillpointd.yaml   and in another terminal   stillpoint watch --domain {}\n",
      state.received, state.lost, options.folder, options.folder, options.folder, options.folder, options.folder,
      stage.dds.domain);
}

int demo(const DemoOptions& options) {
  const auto stage = prepare(options);
  if (!stage) return report(stage.error());
  const auto config = io::read_config(stage->config_path);
  if (!config) return report(config.error());
  Listener listener{stage->recording, {}, {}, {}, 0.0, 0.0};
  const auto subscriber = io::DdsSubscriber::create(
      stage->dds, {.attitude = [&listener](const AttitudeMessage& m, std::int64_t t_ns) { listener.take(m, t_ns); },
                   .calibration = [&listener](const CalibrationMessage& m) { listener.model.take(m); },
                   .diagnostics = [&listener](const DiagnosticsMessage& m) { listener.model.take(m); }});
  if (!subscriber) return report(subscriber.error());
  stop_on_signals();
  const auto program = program_folder() / "stillpointd";
  auto daemon = ChildProcess::start({program, "--config", stage->config_path}, options.folder + "/stillpointd.log");
  if (!daemon) return report(daemon.error());
  if (const auto r = follow(*daemon, listener, *stage, options); !r) return report(r.error());
  const AttitudeScore without = score_without_learning(stage->recording, *config);
  const std::scoped_lock lock(listener.mutex);
  print_end(options, *stage, listener.score, without, listener.model.state(now_ns()));
  if (listener.score.count() == 0)
    return report({ErrorKind::kUnavailable, "no attitude of the second half arrived over DDS"});
  return 0;
}

}  // namespace

void add_demo(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("demo", "The whole product in under a minute, without a sensor");
  static DemoOptions options;
  command->add_option("--seconds", options.seconds, "how long the replay takes")
      ->check(between(3.0, 55.0))
      ->capture_default_str();
  command->add_option("--output", options.folder, "folder for the recording and its truth")->capture_default_str();
  command->add_option("--seed", options.seed, "of the simulated noise")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--domain", options.domain, "DDS domain; by default one of its own")->check(CLI::Range(0, 232));
  command->add_flag("--json", options.json, "the result as JSON on standard output, and nothing else there");
  command->callback([&run] { run = [] { return demo(options); }; });
}

}  // namespace stillpoint::app

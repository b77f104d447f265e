/// `stillpoint demo`: the whole product in under a minute and without a sensor. A simulated hand-held sensor is
/// recorded, the daemon replays it in its own process, this process subscribes over DDS, shows the attitude live, and
/// compares it with the truth, with and without self-calibration.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/stillpoint/child_process.h"
#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/daemon_session.h"
#include "apps/stillpoint/demo_score.h"
#include "apps/stillpoint/demo_stage.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/watch_text.h"
#include "core/clock.h"
#include "core/units.h"
#include "io/config.h"
#include "io/dds_subscriber.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

using Clock = std::chrono::steady_clock;

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
    if (is_scored(recording, row)) score.add(attitude, truth_at(recording, row));
    present_error_rad = attitude.angularDistance(truth_at(recording, row));
    t_s = recording.t_s(row) - recording.t_s(0);
  }
};

/// Standard output is the JSON's alone.
bool is_quiet(const DemoOptions& options) { return options.json == "-"; }

void show(Listener& listener, const DemoStage& stage, bool terminal) {
  const WatchState state = listener.model.state(monotonic_ns());
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
Result<void> follow(ChildProcess& daemon, Listener& listener, const DemoStage& stage, const DemoOptions& options) {
  constexpr double kPatience_s = 20.0;
  const bool terminal = !is_quiet(options) && isatty(STDOUT_FILENO) != 0;
  const auto start = Clock::now();
  auto next_line = start;
  while (!daemon.ended()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto now = Clock::now();
    if (!is_quiet(options) && now >= next_line) {
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

nlohmann::json result_json(const DemoOptions& options, const DemoStage& stage, const AttitudeScore& with,
                           const AttitudeScore& without, const WatchState& state) {
  return {{"schema", "stillpoint.demo/1"},
          {"with_self_calibration", to_json(with)},
          {"without_self_calibration", to_json(without)},
          {"received", state.received},
          {"lost", state.lost},
          {"domain", stage.dds.domain},
          {"seed", options.seed},
          {"recording_s", stage.duration_s},
          {"folder", options.folder}};
}

void print_result(const DemoOptions& options, const DemoStage& stage, const AttitudeScore& with,
                  const AttitudeScore& without, const WatchState& state) {
  fmt::print(
      "\nattitude error without self-calibration {:.1f} deg, with {:.2f} deg (rms over the second half; heading "
      "{:.2f}, inclination {:.2f}; seed {})\n",
      without.total_rad() * kDegPerRad, with.total_rad() * kDegPerRad, with.heading_rad() * kDegPerRad,
      with.inclination_rad() * kDegPerRad, options.seed);
  fmt::print(
      "received {0} attitudes over DDS, lost {1}\nrecording {2}/recording.csv\n\nnow try\n"
      "  stillpoint diagnose --simulation {2}/simulation_without_effects.yaml --recording {2}/recording.csv\n"
      "  stillpoint calibrate --recording {2}/recording.csv\n"
      "  stillpointd --config {2}/stillpointd.yaml   and in another terminal   stillpoint watch --domain {3}\n",
      state.received, state.lost, options.folder, stage.dds.domain);
}

int demo(const DemoOptions& options) {
  const auto stage = prepare_stage(options);
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
  auto daemon = ChildProcess::start({program, "--config", stage->config_path, "--wait-for-subscribers", "1"},
                                    options.folder + "/stillpointd.log");
  if (!daemon) return report(daemon.error());
  if (const auto r = follow(*daemon, listener, *stage, options); !r) return report(r.error());
  const AttitudeScore without = score_without_learning(stage->recording, *config);
  const std::scoped_lock lock(listener.mutex);
  const WatchState state = listener.model.state(monotonic_ns());
  if (!is_quiet(options)) print_result(options, *stage, listener.score, without, state);
  if (!options.json.empty()) {
    const auto json = result_json(options, *stage, listener.score, without, state);
    if (const auto written = io::write_text_file(options.json, json_text(json)); !written)
      return report(written.error());
  }
  if (listener.score.count() == 0)
    return report({ErrorKind::kUnavailable, "no attitude of the second half arrived over DDS"});
  return 0;
}

}  // namespace

void add_demo(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("demo", "The whole product in under a minute, without a sensor");
  static DemoOptions options;
  static JsonOption json;
  command->add_option("--seconds", options.seconds, "how long the replay takes")
      ->check(between(3.0, 55.0))
      ->capture_default_str();
  command->add_option("--output", options.folder, "folder for the recording and its truth")->capture_default_str();
  command->add_option("--seed", options.seed, "of the simulated noise")
      ->check(between(0.0, 2e9))
      ->capture_default_str();
  command->add_option("--domain", options.domain, "DDS domain; by default one of its own")->check(CLI::Range(0, 232));
  json.add(*command, "write the result");
  command->callback([&run] {
    options.json = json.file();
    run = [] { return demo(options); };
  });
}

}  // namespace stillpoint::app

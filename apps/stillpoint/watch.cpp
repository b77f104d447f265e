/// `stillpoint watch`: the live attitude, calibration and latency of a running daemon, in the terminal or as JSON.
#include <unistd.h>

#include <chrono>
#include <thread>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/daemon_session.h"
#include "apps/stillpoint/dds_options.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/screen.h"
#include "apps/stillpoint/watch_text.h"
#include "core/clock.h"
#include "core/units.h"
#include "io/dds_subscriber.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct WatchOptions {
  io::DdsParams dds;
  bool once = false;
  JsonOption json;       ///< instead of text
  double seconds = 0.0;  ///< 0: until interrupted; with once 1 s
  double timeout_s = 10.0;
};

/// Sleeps in short steps until the condition holds, the time is up or a signal came. True: the condition holds.
template <class Condition>
bool wait_for(double seconds, const Condition& condition) {
  const std::int64_t end_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * seconds);
  while (!condition()) {
    if (stop_asked() || monotonic_ns() >= end_ns) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

int print(const WatchState& state, const std::deque<CurvePoint>& curve, const std::string& json_path) {
  const bool lines = json_path == "-";  // one state a line
  const auto written = json_path.empty() ? io::write_text_file("-", text_view(state, curve, takes_colour()))
                                         : io::write_text_file(json_path, json_text(json_view(state), lines ? -1 : 2));
  return written ? 0 : report(written.error());
}

int watch_once(const WatchOptions& options, const WatchModel& model, const io::DdsSubscriber& subscriber) {
  const auto arrived = [&model] { return model.state(monotonic_ns()).received > 0; };
  if (!wait_for(options.timeout_s, arrived))
    return report({ErrorKind::kUnavailable,
                   nothing_arrives(options.dds, options.dds.attitude_topic, subscriber.publishers() > 0)});
  wait_for(options.seconds > 0 ? options.seconds : 1.0, [] { return false; });
  return print(model.state(monotonic_ns()), {}, options.json.file());
}

int watch_live(const WatchOptions& options, const WatchModel& model, const io::DdsSubscriber& subscriber) {
  const bool terminal = options.json.file().empty() && isatty(STDOUT_FILENO) != 0;
  const double step_s = terminal ? 0.2 : 1.0;
  const std::int64_t start_ns = monotonic_ns();
  bool told = false;
  PageModel page;
  while (!stop_asked()) {
    wait_for(step_s, [] { return false; });
    const std::int64_t now_ns = monotonic_ns();
    const WatchState state = model.state(now_ns);
    page.take(state, in_seconds(now_ns - start_ns));
    if (state.received == 0) {
      if (!told && now_ns - start_ns > 1'000'000'000) {
        tell("stillpoint: waiting: " +
             nothing_arrives(options.dds, options.dds.attitude_topic, subscriber.publishers() > 0));
        told = true;
      }
    } else {
      if (terminal) std::fputs("\033[H\033[2J", stdout);
      if (const int code = print(state, page.curve(), options.json.file()); code != 0) return code;
    }
    if (options.seconds > 0 && in_seconds(now_ns - start_ns) >= options.seconds) break;
  }
  if (model.state(monotonic_ns()).received > 0 || options.seconds <= 0) return 0;
  return report(
      {ErrorKind::kUnavailable, nothing_arrives(options.dds, options.dds.attitude_topic, subscriber.publishers() > 0)});
}

int watch(const WatchOptions& options) {
  WatchModel model;
  const auto subscriber = io::DdsSubscriber::create(options.dds, model.handlers());
  if (!subscriber) return report(subscriber.error());
  stop_on_signals();
  return options.once ? watch_once(options, model, **subscriber) : watch_live(options, model, **subscriber);
}

}  // namespace

void add_watch(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("watch", "Show the live attitude, calibration and latency of a running daemon");
  static WatchOptions options;
  add_dds_options(*command, options.dds);
  command->add_flag("--once", options.once, "print one state and end; exit code 69 when no daemon is there");
  options.json.add(*command, "write the state, instead of text,");
  command->add_option("--seconds", options.seconds, "end after this time; with --once the time measured over (1)")
      ->check(between(0.01, 1e9));
  command->add_option("--timeout", options.timeout_s, "with --once: how long to wait for a daemon, s")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
  command->callback([&run] { run = [] { return watch(options); }; });
}

}  // namespace stillpoint::app

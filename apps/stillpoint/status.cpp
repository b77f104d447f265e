/// `stillpoint status`: one screen about a running daemon, for a person or as JSON.
#include <chrono>
#include <thread>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/daemon_session.h"
#include "apps/stillpoint/dds_options.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/status_view.h"
#include "core/clock.h"
#include "io/dds_subscriber.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

struct StatusOptions {
  io::DdsParams dds;
  JsonOption json;  ///< instead of text
  double timeout_s = 10.0;
};

/// Its diagnostics come once a second, the calibration at once, attitudes where the source is not silent.
bool wait_for_diagnostics(const WatchModel& model, double timeout_s) {
  const std::int64_t end_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * timeout_s);
  while (!stop_asked() && monotonic_ns() < end_ns) {
    const WatchState state = model.state(monotonic_ns());
    if (state.diagnostics && state.calibration) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

int status(const StatusOptions& options) {
  WatchModel model;
  const auto subscriber = io::DdsSubscriber::create(options.dds, model.handlers());
  if (!subscriber) return report(subscriber.error());
  stop_on_signals();
  if (!wait_for_diagnostics(model, options.timeout_s))
    return report({ErrorKind::kUnavailable,
                   nothing_arrives(options.dds, options.dds.diagnostics_topic, (*subscriber)->publishers() > 0)});
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // an attitude or two, at 10 Hz and more
  const WatchState state = model.state(monotonic_ns());
  const std::string file = options.json.file();
  const auto written = file.empty() ? io::write_text_file("-", status_text(state))
                                    : io::write_text_file(file, json_text(status_json(state)));
  return written ? 0 : report(written.error());
}

}  // namespace

void add_status(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("status", "Show on one screen how a running daemon and its sensors are");
  static StatusOptions options;
  add_dds_options(*command, options.dds);
  options.json.add(*command, "write the status, instead of text,");
  command->add_option("--timeout", options.timeout_s, "how long to wait for a daemon, s")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
  command->callback([&run] { run = [] { return status(options); }; });
}

}  // namespace stillpoint::app

/// `stillpoint page`: the live attitude, calibration and health of a running daemon as a page for a browser of this
/// machine.
#include <chrono>
#include <thread>

#include "apps/stillpoint/commands.h"
#include "apps/stillpoint/daemon_session.h"
#include "apps/stillpoint/dds_options.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/options.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/page_json.h"
#include "apps/stillpoint/page_server.h"
#include "core/clock.h"
#include "core/units.h"
#include "io/dds_subscriber.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

constexpr auto kEventStep = std::chrono::milliseconds(50);  // 20 Hz, as fast as a person sees

struct PageOptions {
  io::DdsParams dds;
  int port = 8420;
  double seconds = 0.0;  ///< 0: until interrupted
};

int page(const PageOptions& options) {
  WatchModel watched;
  PageModel model;
  const auto subscriber = io::DdsSubscriber::create(options.dds, watched.handlers());
  if (!subscriber) return report(subscriber.error());
  const std::int64_t start_ns = monotonic_ns();
  const auto since_start_s = [start_ns] { return in_seconds(monotonic_ns() - start_ns); };
  const auto state = [&] {
    return json_text(
        page_json(watched.state(monotonic_ns()), model, options.dds, (*subscriber)->publishers(), since_start_s()), -1);
  };
  const auto history = [&model] { return json_text(history_json(model), -1); };
  const auto server = PageServer::create(options.port, page_document(), {state, history});
  if (!server) return report(server.error());
  stop_on_signals();
  const auto told = io::write_text_file("-", fmt::format("http://127.0.0.1:{}/\n", (*server)->port()));
  if (!told) return report(told.error());

  auto next = std::chrono::steady_clock::now();
  while (!stop_asked() && (options.seconds <= 0 || since_start_s() < options.seconds)) {
    model.take(watched.state(monotonic_ns()), since_start_s());
    (*server)->send_event();
    next = std::max(next + kEventStep, std::chrono::steady_clock::now());  // after a pause of the machine no burst
    std::this_thread::sleep_until(next);
  }
  return 0;
}

}  // namespace

void add_page(CLI::App& app, Run& run) {
  auto* command = app.add_subcommand("page", "Serve the live state of a running daemon to a browser of this machine");
  static PageOptions options;
  add_dds_options(*command, options.dds);
  command->add_option("--port", options.port, "port on 127.0.0.1; 0 takes a free one. The address is printed first")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command->add_option("--seconds", options.seconds, "end after this time")->check(between(0.01, 1e9));
  command->callback([&run] { run = [] { return page(options); }; });
}

}  // namespace stillpoint::app

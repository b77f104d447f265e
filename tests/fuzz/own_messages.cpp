/// Our own messages as `watch`, `status`, `page` and `record` receive them, from whoever may send: taken and shown.
#include <stillpoint_idl/stillpointPubSubTypes.h>

#include <nlohmann/json.hpp>

#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/page_model.h"
#include "apps/stillpoint/status_view.h"
#include "apps/stillpoint/watch_model.h"
#include "apps/stillpoint/watch_text.h"
#include "io/dds_convert.h"
#include "tests/fuzz/cdr.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

namespace {

/// One message of the kind that its first byte says; the next two say how long its payload is.
void take(fuzz::Choices& input, app::WatchModel& model, std::int64_t now_ns) {
  const std::uint8_t kind = input.byte() % 4;
  const std::size_t low = input.byte(), high = input.byte();
  const std::string_view payload = input.bytes(low + 256 * high);
  if (msg::Attitude wire; kind == 0 && fuzz::deserialize<msg::AttitudePubSubType>(payload, wire)) {
    AttitudeMessage message;
    if (io::from_wire(wire, message)) model.take(message, now_ns);
  } else if (msg::CalibrationState state;
             kind == 1 && fuzz::deserialize<msg::CalibrationStatePubSubType>(payload, state)) {
    CalibrationMessage message;
    if (io::from_wire(state, message)) model.take(message);
  } else if (msg::Diagnostics diagnostics;
             kind == 2 && fuzz::deserialize<msg::DiagnosticsPubSubType>(payload, diagnostics)) {
    DiagnosticsMessage message;
    io::from_wire(diagnostics, message);
    model.take(message);
  } else if (msg::RawImu raw; kind == 3 && fuzz::deserialize<msg::RawImuPubSubType>(payload, raw)) {
    RawSample sample;
    io::from_wire(raw, sample);
  }
}

bool is_plain(std::string_view text) {
  for (const char c : text)
    if (c != '\n' && (c < ' ' || c > '~')) return false;
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices input(data, size);
  app::WatchModel model;
  app::PageModel page;
  double t_s = 0.0;
  for (std::int64_t now_ns = 1'000'000'000; !input.rest().empty(); now_ns += 100'000'000, t_s += 0.1) {
    take(input, model, now_ns);
    page.take(model.state(now_ns), t_s);
  }
  const app::WatchState state = model.state(2'000'000'000);
  fuzz::expect(is_plain(app::text_view(state, page.curve())), "a terminal is not steered by a message");
  fuzz::expect(nlohmann::json::accept(app::json_text(app::json_view(state))), "what a script reads is JSON");
  if (!state.diagnostics || !state.calibration) return 0;
  fuzz::taken();
  fuzz::expect(is_plain(app::status_text(state)), "a terminal is not steered by a message");
  fuzz::expect(nlohmann::json::accept(app::json_text(app::status_json(state))), "what a script reads is JSON");
  return 0;
}

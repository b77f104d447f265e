/// The daemon's configuration, at its start and when it is read again: faults, each at its place, or values that print
/// to a text that means the same.
#include "apps/stillpointd/live_settings.h"
#include "io/config.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto config = io::parse_config(std::string(fuzz::text(data, size)), "/fuzz/f.yaml");
  if (!config) {
    fuzz::expect(config.error().message.starts_with("/fuzz/f.yaml:"), "a fault names its file", config.error().message);
    return 0;
  }
  fuzz::taken();
  const std::string printed = io::print_config(*config);
  const auto again = io::parse_config(printed, "/elsewhere/f.yaml");
  fuzz::expect(again.has_value(), "what was printed reads back", again ? "" : again.error().message);
  fuzz::expect(io::print_config(*again) == printed, "what was printed means the same", printed);
  const auto change = app::compare(*config, *again);
  fuzz::expect(change.live.empty() && change.at_next_start.empty(), "the same configuration is no change");
  return 0;
}

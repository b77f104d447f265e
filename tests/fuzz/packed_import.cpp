/// A file of any kind through `stillpoint import`: unpacked (gzip, zip), recognised, read; what comes of it is a
/// recording that our own reader takes.
#include "exchange/import.h"
#include "tests/fuzz/recordings.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::MemoryFile file(fuzz::text(data, size));
  const auto imported = exchange::import_recording(file.path(), {});
  if (!imported) {
    fuzz::expect(imported.error().message.starts_with(file.path()), "a fault names its file", imported.error().message);
    return 0;
  }
  fuzz::taken();
  fuzz::expect_sound(imported->recording);
  const fuzz::MemoryFile out("");
  fuzz::expect(io::write_recording(imported->recording, out.path()).has_value(), "the recording can be written");
  const auto again = io::read_recording(out.path());
  fuzz::expect(again.has_value(), "the recording reads back", again ? "" : again.error().message);
  fuzz::expect(again->t_ns == imported->recording.t_ns, "the recording reads back with its times");
  return 0;
}

/// Recordings: refused with a place, or sound; the two ways to treat malformed rows agree on a text without any.
#include "tests/fuzz/recordings.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text(data, size);
  const auto strict = io::parse_recording(text, "f.csv", io::OnMalformedRow::kFail);
  const auto lenient = io::parse_recording(text, "f.csv", io::OnMalformedRow::kCount);
  if (!strict)
    fuzz::expect(strict.error().message.starts_with("f.csv:"), "a fault names its file", strict.error().message);
  if (lenient) {
    fuzz::taken();
    fuzz::expect_sound(*lenient);
    fuzz::expect(io::describe(lenient->issues).size() <= 6 + lenient->issues.unknown_columns.size(), "a line an issue");
    for (const auto& sensor : io::sensor_times(*lenient))
      fuzz::expect(sensor.readings > 0 && sensor.median_step_s >= 0.0, "a sensor was read, forward in time");
  }
  fuzz::expect(strict.has_value() == (lenient && lenient->issues.malformed.count == 0),
               "only malformed rows divide them");
  return 0;
}

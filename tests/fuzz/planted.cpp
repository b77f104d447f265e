/// Defects put in on purpose, by which driver_test.sh tries the driver.
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::taken();
  const std::string_view text = fuzz::text(data, size);
  fuzz::expect(text.find("still point") == std::string_view::npos, "no input says it");
  while (text == "for ever") usleep(1000);
  return 0;
}

/// The file that a calibration is kept in: whole, or refused.
#include "io/state_file.h"

#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::MemoryFile file(fuzz::text(data, size));
  const auto state = io::read_state_file(file.path());
  if (!state) return 0;
  fuzz::taken();
  fuzz::expect(fuzz::text(data, size).ends_with(state->text()), "what is kept is the end of the file");
  return 0;
}

/// PX4's logs.
#include "exchange/ulog.h"

#include "tests/fuzz/recordings.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> reasons;
  fuzz::merge_soundly(exchange::read_ulog(fuzz::text(data, size), "f.ulg", reasons));
  return 0;
}

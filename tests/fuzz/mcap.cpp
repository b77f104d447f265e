/// ROS 2 bags in MCAP: records, chunks of three kinds, messages in CDR.
#include "exchange/mcap.h"

#include "tests/fuzz/recordings.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> reasons;
  fuzz::merge_soundly(exchange::read_mcap(fuzz::text(data, size), "f.mcap", "/imu", reasons));
  return 0;
}

/// Lines of CSV or JSON of a live source. Its configuration is one of those of docs/sources.md: columns by header, by
/// position, by the stream's own names.
#include "tests/fuzz/streams.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices input(data, size);
  io::StreamParams params;
  params.format = io::StreamFormat::kText;
  params.acc_mps2_per_count = 0.001;
  const std::uint8_t columns = input.byte() % 3;
  if (columns == 1)
    params.columns = {{"time_us", "1"}, {"acc_x_counts", "2"}, {"acc_y_counts", "3"}, {"acc_z_counts", "4"}};
  if (columns == 2)
    params.columns = {{"gyr_x_dps", "imu.w.x"}, {"gyr_y_dps", "gy"}, {"gyr_z_dps", "gz"}, {"time_ms", "t"}};
  fuzz::read_stream(params, input);
  return 0;
}

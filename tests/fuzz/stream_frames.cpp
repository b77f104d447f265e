/// Binary frames of a live source, alone and where the format is found out.
#include "tests/fuzz/streams.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices input(data, size);
  io::StreamParams params;
  params.format = input.byte() % 2 == 0 ? io::StreamFormat::kAuto : io::StreamFormat::kFrames;
  fuzz::read_stream(params, input);
  return 0;
}

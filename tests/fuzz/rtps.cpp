/// Datagrams as the gate before Fast DDS judges them. What it lets in is such that it lets it in again, unchanged.
#include "io/dds_rtps.h"

#include <vector>

#include "io/dds_admission.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> datagram(data, data + size);
  const auto message = io::judge_rtps(datagram);
  if (!message) return 0;
  fuzz::taken();
  fuzz::expect(datagram.size() == size, "a datagram keeps its length");
  const std::vector<std::uint8_t> let_in = datagram;
  const auto again = io::judge_rtps(datagram);
  fuzz::expect(again && datagram == let_in, "what was let in is let in again, unchanged");
  fuzz::expect(again->sender == message->sender && again->announces_participant == message->announces_participant &&
                   again->announces_for_another == message->announces_for_another,
               "it means the same");
  io::Admission admission;
  fuzz::expect(admission.admit(message->sender, 1, 1'000'000'000), "the first one is let in");
  return 0;
}

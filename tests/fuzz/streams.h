/// A live stream as it arrives: in pieces of any length, cut now and then, its readings stamped and its datagrams
/// ended.
#pragma once
#include <algorithm>
#include <cmath>

#include "sources/splitter.h"
#include "sources/stamps.h"
#include "tests/fuzz/fuzz.h"

namespace stillpoint::fuzz {

/// After the four choices at its front the input is what the sender wrote.
inline void read_stream(const io::StreamParams& params, Choices input) {
  sources::Splitter splitter(params);
  sources::Stamps stamps(params.rate_hz);
  const std::size_t longest = 1 + 4 * std::size_t{input.byte()}, cut_every = input.byte(), datagrams = input.byte() % 2;
  const std::int64_t period_ns = 1'000'000 * (1 + std::int64_t{input.byte()});
  std::int64_t arrival_ns = 1'000'000'000;
  for (std::size_t piece = 1; !input.rest().empty(); ++piece, arrival_ns += period_ns) {
    const auto room = splitter.room();
    expect(!room.empty(), "there is room for what arrives next");
    const std::string_view bytes = input.bytes(std::min(longest, room.size()));
    std::copy(bytes.begin(), bytes.end(), room.begin());
    splitter.received(bytes.size());
    if (datagrams != 0) splitter.end_of_datagram();
    sources::Reading reading;
    std::uint64_t steps = 0;
    while (splitter.next(reading, steps) == sources::Piece::kReading) {
      expect(reading.sample.has != 0 && steps > 0, "a reading holds something and moves the count on");
      stamps.stamp(reading, arrival_ns, steps);
      taken();
    }
    expect(splitter.last_refused().size() <= 60, "what is shown of a refused line is short");
    if (cut_every == 0 || piece % cut_every != 0) continue;
    splitter.restart(piece % 2 == 0);
    stamps.restart();
  }
}

}  // namespace stillpoint::fuzz

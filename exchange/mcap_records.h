/// What stands in an MCAP file: its first bytes and the kinds of its records (mcap.dev/spec).
#pragma once
#include <cstdint>
#include <string_view>

namespace stillpoint::exchange::mcap {

inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 11,
  kDataEnd = 15
};

}  // namespace stillpoint::exchange::mcap

/// Judges a datagram before Fast DDS reads it. Debian's Fast DDS 2.9.1 trusts what a datagram says about its own
/// lengths and counts, and ends the program on some that lie (docs/decisions/100-hostile-neighbours.md). Pure: bytes
/// in, verdict out.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace stillpoint::io {

using GuidPrefix = std::array<std::uint8_t, 12>;

struct RtpsMessage {
  GuidPrefix sender{};
  bool announces_participant = false;  ///< holds data of the participant discovery (SPDP)
  bool announces_for_another = false;  ///< of a participant that is not the sender: only a discovery server does that
};

/// None: malformed, to be refused. Otherwise every length, count, range and string in it lies inside it, as RTPS 2.3
/// (OMG formal/2019-04-03, 8.3.7, 9.4.5 and 9.6.3) defines them. What nobody here needs is made into padding in place:
/// submessages of a vendor's own, type objects and content filters.
[[nodiscard]] std::optional<RtpsMessage> judge_rtps(std::span<std::uint8_t> datagram) noexcept;

}  // namespace stillpoint::io

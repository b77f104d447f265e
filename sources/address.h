/// Where a stream comes from, out of the text of `source: from`.
#pragma once
#include <cstdint>
#include <string>

#include "core/result.h"

namespace stillpoint::sources {

enum class AddressKind : std::uint8_t { kStdin, kPath, kTcp, kTcpListen, kUdp };

struct Address {
  AddressKind kind = AddressKind::kStdin;
  std::string path;  ///< of a file, a FIFO or a device
  std::string host;  ///< an IPv4 address; 127.0.0.1 where the text names none
  std::uint16_t port = 0;
};

/// Fails (78) with what is wrong and what is known.
[[nodiscard]] Result<Address> parse_address(const std::string& from);

}  // namespace stillpoint::sources

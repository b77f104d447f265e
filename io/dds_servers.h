/// Discovery servers: participants that tell each client only of those that concern it, so that a fleet need not
/// announce itself to everybody. Addresses and names are those of ROS 2's ROS_DISCOVERY_SERVER.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/result.h"

namespace stillpoint::io {

struct ServerAddress {
  std::string address;  ///< IPv4
  std::uint16_t port = 0;
};

/// "ADDRESS" or "ADDRESS:PORT". Fails in words.
[[nodiscard]] Result<ServerAddress> parse_server(const std::string& text);

/// The name of the server at this position of the list: `fastdds discovery -i POSITION` calls itself so.
[[nodiscard]] std::array<std::uint8_t, 12> server_prefix(std::size_t position);

inline constexpr std::size_t kMostServers = 256;  // the position is one byte of the name

}  // namespace stillpoint::io

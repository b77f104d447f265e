#include "io/dds_servers.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>

namespace stillpoint::io {

Result<ServerAddress> parse_server(const std::string& text) {
  constexpr std::uint16_t kUsualPort = 11811;
  const auto colon = text.find(':');
  ServerAddress out{text.substr(0, colon), kUsualPort};
  in_addr address{};
  if (inet_pton(AF_INET, out.address.c_str(), &address) != 1)
    return fail(ErrorKind::kBadConfig,
                fmt::format("'{}' is no IPv4 address with a port, such as 127.0.0.1:11811", text));
  if (colon == std::string::npos) return out;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + colon + 1, end, out.port);
  if (read.ec != std::errc{} || read.ptr != end || out.port == 0)
    return fail(ErrorKind::kBadConfig, fmt::format("'{}': the port is '{}'; it must be 1 to 65535, usual is {}", text,
                                                   text.substr(colon + 1), kUsualPort));
  return out;
}

std::array<std::uint8_t, 12> server_prefix(std::size_t position) {
  return {0x44, 0x53, static_cast<std::uint8_t>(position), 0x5f, 0x45, 0x50, 0x52, 0x4f, 0x53, 0x49, 0x4d, 0x41};
}

}  // namespace stillpoint::io

#include "sources/address.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>
#include <utility>

#include "io/quote.h"

namespace stillpoint::sources {

Result<Address> parse_address(const std::string& from) {
  const auto wrong = [&from](const std::string& what) {
    return fail(
        ErrorKind::kBadConfig,
        fmt::format("{} {}; use stdin, a path, tcp://HOST:PORT, tcp-listen://:PORT or udp://:PORT, with HOST an "
                    "IPv4 address (none: 127.0.0.1)",
                    io::quote(from), what));
  };
  Address out;
  if (from.empty()) return wrong("is empty");
  if (from == "stdin" || from == "-") return out;
  const std::size_t scheme_end = from.find("://");
  if (scheme_end == std::string::npos) {
    out.kind = AddressKind::kPath;
    out.path = from;
    return out;
  }
  const std::string scheme = from.substr(0, scheme_end), rest = from.substr(scheme_end + 3);
  constexpr std::pair<const char*, AddressKind> kSchemes[] = {
      {"tcp", AddressKind::kTcp}, {"tcp-listen", AddressKind::kTcpListen}, {"udp", AddressKind::kUdp}};
  bool known = false;
  for (const auto& [name, kind] : kSchemes)
    if (scheme == name) out.kind = kind, known = true;
  if (!known) return wrong(fmt::format("begins with the unknown {}", io::quote(scheme)));
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string::npos) return wrong("names no port");
  out.host = rest.substr(0, colon);
  if (out.host.empty() || out.host == "localhost") out.host = "127.0.0.1";
  in_addr ignored{};
  if (inet_pton(AF_INET, out.host.c_str(), &ignored) != 1) return wrong("names no IPv4 address");
  const char* end = rest.data() + rest.size();
  const auto [stop, code] = std::from_chars(rest.data() + colon + 1, end, out.port);
  if (code != std::errc{} || stop != end || out.port == 0) return wrong("names no port from 1 to 65535");
  return out;
}

}  // namespace stillpoint::sources

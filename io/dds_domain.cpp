#include "io/dds_domain.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>

namespace stillpoint::io {
namespace {

constexpr int kDomains = 100;

/// Binds the name `stillpoint-domain-N`, which lies in no folder and is free again when the process ends.
bool claim(int domain) noexcept {
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // An empty first byte: the abstract namespace.
  std::snprintf(address.sun_path + 1, sizeof address.sun_path - 1, "stillpoint-domain-%d", domain);
  if (fd >= 0 && bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      !is_domain_in_use(domain))
    return true;  // stays open as long as the process lives
  if (fd >= 0) close(fd);
  return false;
}

}  // namespace

bool is_domain_in_use(int domain) noexcept {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * domain));
  // Participants share the port among themselves; one who does not share is refused.
  const bool in_use = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0;
  close(fd);
  return in_use;
}

int own_domain() noexcept {
  static const int domain = [] {
    for (int k = 0; k < kDomains; ++k)
      if (const int candidate = 1 + (getpid() + k) % kDomains; claim(candidate)) return candidate;
    return 0;
  }();
  return domain;
}

}  // namespace stillpoint::io

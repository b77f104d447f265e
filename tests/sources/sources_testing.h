/// What the tests of the sources share.
#pragma once
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "core/clock.h"
#include "pipeline/stage.h"
#include "tests/scratch_folder.h"

namespace stillpoint::test {

/// Asks until the source gives this answer.
template <pipeline::Source S>
bool eventually_state(S& source, pipeline::Arrival& out, pipeline::SourceState wanted, double seconds = 10.0) {
  const auto until_ns = monotonic_ns() + static_cast<std::int64_t>(1e9 * seconds);
  while (monotonic_ns() < until_ns)
    if (source.next(out) == wanted) return true;
  return false;
}
template <pipeline::Source S>
bool eventually_sample(S& source, pipeline::Arrival& out, double seconds = 10.0) {
  return eventually_state(source, out, pipeline::SourceState::kSample, seconds);
}

inline sockaddr_in on_loopback(std::uint16_t port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return at;
}

/// A port of the loopback that nobody had a moment ago.
inline std::uint16_t free_port() {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in any = on_loopback(0);
  socklen_t size = sizeof any;
  const bool bound = bind(fd, reinterpret_cast<sockaddr*>(&any), size) == 0 &&
                     getsockname(fd, reinterpret_cast<sockaddr*>(&any), &size) == 0;
  close(fd);
  return bound ? ntohs(any.sin_port) : std::uint16_t{0};
}

}  // namespace stillpoint::test

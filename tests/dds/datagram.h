/// A UDP socket on loopback for tests that play a neighbour, and the datagrams it sends.
#pragma once
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "tests/dds/dds_testing.h"

namespace stillpoint::test {

/// Bound to the port where it is given one.
class Socket {
 public:
  explicit Socket(int port = 0) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in own = address(port);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
  }
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  void send(const std::string& data, int port) const {
    const sockaddr_in to = address(port);
    sendto(fd_, data.data(), data.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  [[nodiscard]] std::string receive() const {
    std::string data(65536, '\0');
    const ssize_t n = recv(fd_, data.data(), data.size(), 0);
    data.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return data;
  }

 private:
  static sockaddr_in address(int port) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_port = htons(static_cast<std::uint16_t>(port));
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return a;
  }
  int fd_;
};

/// Ports of RTPS 9.6: the group's; of discovery for even k, of data for odd k, two for each participant of the domain.
inline int group_port() { return 7400 + 250 * test_params().domain; }
inline int port(int k) { return group_port() + 10 + k; }

/// The announcement of one of our participants, caught where the ninth participant of the domain would listen. The
/// goodbye of one before it is shorter.
inline std::string announcement() {
  constexpr std::size_t kLongerThanAGoodbye = 300;
  const Socket ninth(port(16));
  std::string data = ninth.receive();
  while (data.size() <= kLongerThanAGoodbye) data = ninth.receive();
  return data;
}

/// Aborts a program with Debian's Fast DDS 2.9.1: a submessage of eProsima's statistics about nothing.
inline std::string statistics_datagram() {
  return std::string("RTPS\x02\x03\x01\x0f", 8) + std::string(12, '\0') + std::string("\x80\x01\x38\x00", 4) +
         std::string(60, '\0');
}

/// The announcement with an identity token that claims two thousand million properties and holds none.
inline std::string with_boundless_token(std::string announcement) {
  const std::string token(
      "\x01\x10\x18\0"        // an identity token of 24 bytes
      "\x08\0\0\0DDS:Id\0\0"  // its class
      "\xff\xff\xff\x7f\0\0\0\0\0\0\0\0",
      28);
  constexpr std::size_t kHeader = 20, kEnd = 4;
  for (std::size_t at = kHeader; at + 4 <= announcement.size();) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(announcement[at + k]); };
    const std::size_t length = byte(2) + 256U * byte(3), longer = length + token.size();
    if (byte(0) == 0x15) {
      announcement[at + 2] = static_cast<char>(longer % 256);
      announcement[at + 3] = static_cast<char>(longer / 256);
      return announcement.insert(at + 4 + length - kEnd, token);
    }
    at += 4 + length;
  }
  return {};
}

}  // namespace stillpoint::test

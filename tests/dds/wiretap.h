/// What goes over loopback, as anybody with the right to look sees it.
#pragma once
#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace stillpoint::test {

class Wiretap {
 public:
  Wiretap() : fd_(socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_IP))) {
    if (fd_ < 0) return;
    constexpr int kRoom_bytes = 32 << 20;
    setsockopt(fd_, SOL_SOCKET, SO_RCVBUFFORCE, &kRoom_bytes, sizeof kRoom_bytes);
    sockaddr_ll loopback{};
    loopback.sll_family = AF_PACKET;
    loopback.sll_protocol = htons(ETH_P_IP);
    loopback.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
    ready_ = bind(fd_, reinterpret_cast<const sockaddr*>(&loopback), sizeof loopback) == 0;
  }
  ~Wiretap() {
    if (fd_ >= 0) close(fd_);
  }
  Wiretap(const Wiretap&) = delete;
  Wiretap& operator=(const Wiretap&) = delete;
  [[nodiscard]] bool ready() const { return ready_; }

  /// The packets since the last call, one behind the other.
  std::string take() {
    std::string all, one(65536, '\0');
    for (ssize_t n = 0; (n = recv(fd_, one.data(), one.size(), 0)) > 0;)
      all.append(one, 0, static_cast<std::size_t>(n));
    return all;
  }

 private:
  int fd_;
  bool ready_ = false;
};

}  // namespace stillpoint::test

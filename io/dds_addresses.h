/// The IPv4 addresses of this machine, as they are now.
#pragma once
#include <cstdint>
#include <mutex>
#include <vector>

namespace stillpoint::io {

/// In network byte order.
[[nodiscard]] std::vector<std::uint32_t> local_addresses();

/// Asked for every datagram: looks anew at most once a second, and only for an address that it does not know.
class LocalAddresses {
 public:
  [[nodiscard]] bool has(std::uint32_t address) noexcept;

 private:
  std::mutex mutex_;
  std::vector<std::uint32_t> known_;
  std::int64_t looked_ns_ = 0;
};

}  // namespace stillpoint::io

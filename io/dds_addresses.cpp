#include "io/dds_addresses.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstring>

#include "core/clock.h"

namespace stillpoint::io {

std::vector<std::uint32_t> local_addresses() {
  std::vector<std::uint32_t> out;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return out;
  for (const ifaddrs* i = all; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET || (i->ifa_flags & IFF_UP) == 0) continue;
    out.push_back(reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr.s_addr);
  }
  freeifaddrs(all);
  return out;
}

bool LocalAddresses::has(std::uint32_t address) noexcept {
  constexpr std::uint32_t kLoopbackNet = 127;
  constexpr std::int64_t kLookAgain_ns = 1'000'000'000;
  if (ntohl(address) >> 24U == kLoopbackNet) return true;
  const std::lock_guard lock(mutex_);
  if (std::find(known_.begin(), known_.end(), address) != known_.end()) return true;
  const std::int64_t now_ns = monotonic_ns();
  if (looked_ns_ != 0 && now_ns - looked_ns_ < kLookAgain_ns) return false;
  looked_ns_ = now_ns;
  known_ = local_addresses();
  return std::find(known_.begin(), known_.end(), address) != known_.end();
}

}  // namespace stillpoint::io

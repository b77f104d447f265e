/// FNV-1a, 64 bit (Fowler, Noll, Vo): tells texts apart and notices damage; no guard against malice.
#pragma once
#include <cstdint>
#include <string_view>

namespace stillpoint {

/// `before`: the hash of what comes before these bytes.
[[nodiscard]] constexpr std::uint64_t fnv1a(std::string_view bytes,
                                            std::uint64_t before = 0xcbf29ce484222325U) noexcept {
  for (const char c : bytes) before = (before ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return before;
}

}  // namespace stillpoint

/// Strings, octets and sequences of them as CDR writes them (RTPS 2.3, 10), judged in bytes that nobody has checked.
/// Each function looks from `at` on, and on true has moved `at` behind what it found.
#pragma once
#include <cstddef>

#include "io/dds_rtps_bytes.h"

namespace stillpoint::io {

constexpr std::size_t aligned(std::size_t n) { return (n + 3) / 4 * 4; }

/// A length, and so many bytes.
inline bool is_octets(const RtpsBytes& value, std::size_t& at) noexcept {
  if (!value.has(at, 4)) return false;
  const std::size_t length = value.u32(at);
  if (!value.has(at + 4, length)) return false;
  at += 4 + aligned(length);
  return true;
}

/// The same, and the last byte is zero.
inline bool is_text(const RtpsBytes& value, std::size_t& at) noexcept {
  const std::size_t length = value.u32(at), last = at + 4 + length - 1;
  return is_octets(value, at) && (length == 0 || value.u8(last) == 0);
}

inline bool are_two_texts(const RtpsBytes& value, std::size_t& at) noexcept {
  return is_text(value, at) && is_text(value, at);
}

/// A count, and so many elements of at least `least` bytes: Fast DDS makes room for all of them before it reads one.
template <class IsElement>
bool is_sequence(const RtpsBytes& value, std::size_t& at, std::size_t least, const IsElement& is_element) noexcept {
  if (!value.has(at, 4)) return false;
  const std::size_t count = value.u32(at);
  at += 4;
  if (count > value.size() / least) return false;
  for (std::size_t k = 0; k < count; ++k)
    if (!is_element(value, at)) return false;
  return true;
}

}  // namespace stillpoint::io

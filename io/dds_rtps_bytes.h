/// Reading numbers of either byte order out of bytes that nobody has checked.
#pragma once
#include <cstdint>
#include <cstring>
#include <span>

namespace stillpoint::io {

/// Reading beyond the end gives 0; callers ask has() first where that matters.
class RtpsBytes {
 public:
  RtpsBytes(std::span<std::uint8_t> bytes, bool little_endian) noexcept : bytes_(bytes), little_(little_endian) {}

  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size(); }
  [[nodiscard]] bool little_endian() const noexcept { return little_; }
  /// `n` bytes from `at` on lie inside.
  [[nodiscard]] bool has(std::size_t at, std::size_t n) const noexcept {
    return at <= bytes_.size() && n <= bytes_.size() - at;
  }
  [[nodiscard]] std::uint8_t u8(std::size_t at) const noexcept { return has(at, 1) ? bytes_[at] : std::uint8_t{0}; }
  [[nodiscard]] std::uint16_t u16(std::size_t at) const noexcept {
    const unsigned first = u8(at), second = u8(at + 1);
    return static_cast<std::uint16_t>(little_ ? first | second << 8U : first << 8U | second);
  }
  [[nodiscard]] std::uint32_t u32(std::size_t at) const noexcept {
    const std::uint32_t first = u16(at), second = u16(at + 2);
    return little_ ? first | second << 16U : first << 16U | second;
  }
  /// A sequence number: the high half comes first in either byte order.
  [[nodiscard]] std::int64_t sequence_number(std::size_t at) const noexcept {
    const std::uint64_t high = u32(at), low = u32(at + 4);
    return static_cast<std::int64_t>(high << 32U | low);
  }
  void clear_u16(std::size_t at) noexcept {
    if (has(at, 2)) std::memset(bytes_.data() + at, 0, 2);
  }
  void set_u16(std::size_t at, std::uint16_t value) noexcept {
    if (!has(at, 2)) return;
    const auto low = static_cast<std::uint8_t>(value & 0xffU), high = static_cast<std::uint8_t>(value >> 8U);
    bytes_[at] = little_ ? low : high;
    bytes_[at + 1] = little_ ? high : low;
  }
  /// The rest from `at` on, in the same or another byte order.
  [[nodiscard]] RtpsBytes from(std::size_t at) const noexcept { return from(at, little_); }
  [[nodiscard]] RtpsBytes from(std::size_t at, bool little_endian) const noexcept {
    return {bytes_.subspan(at <= bytes_.size() ? at : bytes_.size()), little_endian};
  }
  [[nodiscard]] RtpsBytes part(std::size_t at, std::size_t n) const noexcept {
    return has(at, n) ? RtpsBytes(bytes_.subspan(at, n), little_) : RtpsBytes({}, little_);
  }
  [[nodiscard]] const std::uint8_t* data() const noexcept { return bytes_.data(); }

 private:
  std::span<std::uint8_t> bytes_;
  bool little_;
};

}  // namespace stillpoint::io

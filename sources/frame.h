/// The binary frame of a stream (docs/sources.md): pure functions over bytes.
///
///   A5 5A | length n | counter | n bytes of payload | CRC-16
///   payload: flags, [time in us, 32 bits], then what the flags name, as 32-bit floats: acc, gyr, mag (x, y, z), temp
///
/// Little-endian; the CRC (CCITT, 0x1021, begins with 0xFFFF) covers length, counter and payload.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "sources/reading.h"

namespace stillpoint::sources {

inline constexpr std::array<std::uint8_t, 2> kSync{0xA5, 0x5A};
inline constexpr std::size_t kFrameOverhead = 6;
inline constexpr std::size_t kLongestPayload = 1 + 4 + 10 * 4;
inline constexpr std::size_t kLongestFrame = kFrameOverhead + kLongestPayload;
inline constexpr std::uint8_t kFrameHasTime = 0x10;  ///< in the flags, beside the bits of SamplePart

[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept;

struct Frame {
  Piece piece = Piece::kNone;
  std::size_t size = 0;  ///< bytes to take off the front: of the frame, or of what is none
  std::uint8_t counter = 0;
  Reading reading;
};

/// Looks at the front of what has arrived. kNone with a size of 0: wait for more; kMalformed: `size` bytes are no
/// frame.
[[nodiscard]] Frame take_frame(std::span<const std::uint8_t> bytes) noexcept;

/// The frame of a reading; the bytes written. For tests, and for senders in C++.
std::size_t write_frame(const Reading& reading, std::uint8_t counter,
                        std::span<std::uint8_t, kLongestFrame> out) noexcept;

}  // namespace stillpoint::sources

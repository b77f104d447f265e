/// Values and attributes of the kernel's IIO subsystem as it writes them: pure functions.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/types.h"

namespace stillpoint::sources {

/// A channel of a triad or the thermometer; from names such as accel_x, anglvel_z, magn_y, temp.
struct IioChannelKind {
  SamplePart part = kAcc;
  std::size_t axis = 0;
  double unit = 1.0;  ///< factor from the subsystem's unit (m/s^2, rad/s, gauss, m degC) to ours
};
[[nodiscard]] std::optional<IioChannelKind> iio_channel_kind(std::string_view id) noexcept;

/// "1, 0, 0; 0, 1, 0; 0, 0, 1": device axes from chip axes. None: it is no rotation, or no matrix.
[[nodiscard]] std::optional<Mat3> parse_mount_matrix(std::string_view text) noexcept;

/// (raw + offset) * scale, in our units.
struct IioScale {
  double offset = 0.0, scale = 1.0;
  [[nodiscard]] double apply(double raw) const noexcept { return (raw + offset) * scale; }
};

/// How an element lies in a buffer: "le:s16/32>>0" in the subsystem's words.
struct IioElement {
  bool big_endian = false, is_signed = false;
  unsigned bits = 0, storage_bits = 0, shift = 0;
};

/// Pre: 0 < bits, bits + shift <= storage_bits <= 64. The value of an element. Bits beyond `bits` are masked: the
/// storage may hold the next axis there.
[[nodiscard]] std::int64_t iio_element_value(const std::uint8_t* bytes, const IioElement& element) noexcept;

}  // namespace stillpoint::sources

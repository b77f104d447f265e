#include "sources/iio_values.h"

#include <charconv>

#include "io/mount.h"

namespace stillpoint::sources {
namespace {

constexpr double kMicroTeslaPerGauss = 100.0;

/// Takes `head` off the text when it begins with it.
bool take(std::string_view& text, std::string_view head) noexcept {
  if (!text.starts_with(head)) return false;
  text.remove_prefix(head.size());
  return true;
}

template <class T>
bool take_number(std::string_view& text, T& value) noexcept {
  const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
  return true;
}

}  // namespace

std::optional<IioChannelKind> iio_channel_kind(std::string_view id) noexcept {
  if (id == "temp" || id == "temp_ambient" || id == "temp0") return IioChannelKind{kTemp, 0, 1e-3};
  IioChannelKind kind;
  if (take(id, "accel_"))
    kind.part = kAcc;
  else if (take(id, "anglvel_"))
    kind.part = kGyr;
  else if (take(id, "magn_"))
    kind = {kMag, 0, kMicroTeslaPerGauss};
  else
    return std::nullopt;
  if (id.size() != 1 || id[0] < 'x' || id[0] > 'z') return std::nullopt;
  kind.axis = static_cast<std::size_t>(id[0] - 'x');
  return kind;
}

std::optional<Mat3> parse_mount_matrix(std::string_view text) noexcept {
  Mat3 M;
  for (Eigen::Index k = 0; k < 9; ++k) {
    while (!text.empty() && (text[0] == ' ' || text[0] == ',' || text[0] == ';')) text.remove_prefix(1);
    if (!take_number(text, M(k / 3, k % 3))) return std::nullopt;
  }
  const auto mount = io::mount_of_matrix(M);
  const auto* good = std::get_if<io::Mount>(&mount);
  return good != nullptr ? std::optional(good->R_body_sensor) : std::nullopt;
}

std::int64_t iio_element_value(const std::uint8_t* bytes, const IioElement& element) noexcept {
  const unsigned size = element.storage_bits / 8;
  std::uint64_t raw = 0;
  for (unsigned k = 0; k < size; ++k)
    raw |= static_cast<std::uint64_t>(bytes[element.big_endian ? size - 1 - k : k]) << (8U * k);
  raw >>= element.shift;
  if (element.bits == 64) return static_cast<std::int64_t>(raw);
  const std::uint64_t mask = (std::uint64_t{1} << element.bits) - 1;
  raw &= mask;
  const bool negative = element.is_signed && (raw >> (element.bits - 1U)) != 0;
  return static_cast<std::int64_t>(negative ? raw | ~mask : raw);
}

}  // namespace stillpoint::sources

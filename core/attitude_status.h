/// How far an attitude can be relied on, and what its heading counts from. The numbers are those of the wire
/// (idl/stillpoint.idl).
#pragma once
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>

namespace stillpoint {

enum class AttitudeStatus : std::uint8_t {
  kInitializing,  ///< no attitude yet: identity quaternion, covariance of ignorance
  kOk,
  kDegraded,  ///< a sensor is clipped, disturbed, missing or late; the covariance says how much that costs
  kStale,     ///< the source stopped; the last attitude, growing older
};

enum class HeadingReference : std::uint8_t {
  kRelative,   ///< no magnetic heading so far: it counts from the initial heading and drifts with the gyroscope
  kMagnetic,   ///< the magnetometer is trusted: from magnetic east
  kTrue,       ///< the same from true east, by a configured declination
  kDisturbed,  ///< there was a magnetic heading, but the field is not the reference field: the gyroscope carries it
};

/// "unknown" for a number from the wire that is none of these.
[[nodiscard]] constexpr std::string_view name(AttitudeStatus status) noexcept {
  constexpr std::string_view kNames[] = {"initializing", "ok", "degraded", "stale"};
  const auto i = static_cast<std::size_t>(status);
  return i < std::size(kNames) ? kNames[i] : "unknown";
}
[[nodiscard]] constexpr std::string_view name(HeadingReference reference) noexcept {
  constexpr std::string_view kNames[] = {"relative", "magnetic", "true", "disturbed"};
  const auto i = static_cast<std::size_t>(reference);
  return i < std::size(kNames) ? kNames[i] : "unknown";
}

}  // namespace stillpoint

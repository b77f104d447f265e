/// Constants and conversions at the edges; inside everything is SI and radians.
#pragma once
#include <concepts>
#include <numbers>

namespace stillpoint {

inline constexpr double kTwoPi = 2.0 * std::numbers::pi;
inline constexpr double kEarthRate_radps = 7.292115e-5;
inline constexpr double kStandardGravity_mps2 = 9.80665;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kSecondsPerNs = 1e-9;
inline constexpr double kNsPerSecond = 1e9;

[[nodiscard]] constexpr double in_seconds(std::integral auto ns) noexcept {
  return kSecondsPerNs * static_cast<double>(ns);
}
[[nodiscard]] constexpr double squared(double v) noexcept { return v * v; }

}  // namespace stillpoint

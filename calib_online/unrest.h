/// What the surroundings do to the length of the specific force: a swell, a ride. Seen from window to window in one
/// attitude, where the calibration drops out.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace stillpoint::calib {

struct Unrest {
  static constexpr std::size_t kSteps = 7;
  static constexpr std::uint32_t kLeast = 4;
  std::array<double, kSteps> steps{};  ///< of the norm, relative
  std::uint32_t count = 0;
  double last_norm = 0.0;

  void see(double norm, bool same_attitude) noexcept {
    if (same_attitude) steps[count++ % kSteps] = std::abs(norm - last_norm);
    last_norm = norm;
  }
  /// Variance of one window's norm, relative. By the middle step: a single push says nothing of the next window.
  [[nodiscard]] double variance() const noexcept {
    if (count < kLeast) return 0.0;
    auto sorted = steps;
    const auto n = std::min<std::size_t>(count, kSteps);
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n));
    constexpr double kOfNormal = 0.6745;  // the middle absolute deviation of a normal distribution, in sd
    const double sd = sorted[n / 2] / kOfNormal;
    return 0.5 * sd * sd;
  }
};

}  // namespace stillpoint::calib

/// What the surroundings do to the length of the specific force: a swell, a ride. Seen from window to window in one
/// attitude, where the calibration drops out; and in steps of its direction that are no turn, for what pushes sideways
/// makes it longer, too.
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
  /// The largest step of direction that was no turn, rad^2, fading: over a minute and a half for the norm, where what a
  /// push taught stays; over twenty seconds for the direction of the present window.
  double sideways_sq = 0.0, sideways_now_sq = 0.0;

  /// `step_rad`: of the direction since the window before, its turn taken out; 0 where that is not known.
  void see(double norm, bool same_attitude, double step_rad) noexcept {
    constexpr double kMemory = 0.98, kMemoryNow = 0.9;  // of a window
    sideways_sq *= kMemory;
    sideways_now_sq *= kMemoryNow;
    if (same_attitude) {
      steps[count++ % kSteps] = std::abs(norm - last_norm);
      sideways_sq = std::max(sideways_sq, step_rad * step_rad);
      sideways_now_sq = std::max(sideways_now_sq, step_rad * step_rad);
    }
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
  /// The same of what pushes sideways: half its square is what it adds to the norm.
  [[nodiscard]] double sideways_variance() const noexcept { return 0.25 * sideways_sq * sideways_sq; }
};

}  // namespace stillpoint::calib

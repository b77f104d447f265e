#include "fusion/motion_scale.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {
namespace {

constexpr double kMeanOver = 2.0;   ///< correlation times that the velocity is averaged over
constexpr double kSurprise = 9.0;   ///< chi-square of one: three standard deviations
constexpr double kLeftOver = 2.0;   ///< what the surprise is brought down to: one jump does not settle it
constexpr double kMemory_s = 20.0;  ///< a car stops at lights and goes on
constexpr double kLargest = 1e8;    ///< ten thousand times the usual speed

}  // namespace

double MotionScale::time() const noexcept { return std::sqrt(scale_); }

void MotionScale::observe(const std::array<double, 2>& velocity_mps, const std::array<double, 2>& variance_m2ps2,
                          double usual_speed_mps, double usual_time_s, double period_s) noexcept {
  const double blend = 1.0 - std::exp(-period_s / (kMeanOver * usual_time_s * time()));
  // Of a first-order process the mean with this memory keeps 1 / (1 + kMeanOver) of the variance.
  const double usual2 = usual_speed_mps * usual_speed_mps * scale_ / (1.0 + kMeanOver);
  double surprise = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    mean_velocity_mps_[i] += blend * (velocity_mps[i] - mean_velocity_mps_[i]);
    surprise = std::max(surprise, mean_velocity_mps_[i] * mean_velocity_mps_[i] / (usual2 + variance_m2ps2[i]));
  }
  scale_ = 1.0 + (scale_ - 1.0) * std::exp(-period_s / kMemory_s);
  if (surprise > kSurprise) scale_ = std::min(kLargest, scale_ * surprise / kLeftOver);
  if (!std::isfinite(scale_)) *this = {};
}

}  // namespace stillpoint::fusion

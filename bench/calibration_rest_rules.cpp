#include "bench/calibration_rest_rules.h"

#include <array>
#include <cmath>

#include "calib_online/slow_change.h"
#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::bench {
namespace {

Vec3 mean_force(std::span<const MotionSample> window) {
  Vec3 sum = Vec3::Zero();
  for (const auto& s : window) sum += s.acc_mps2;
  return sum / static_cast<double>(window.size());
}

/// Quarter means in the frame of the middle sample.
std::array<Vec3, 4> turned_quarters(std::span<const MotionSample> window, double dt_s) {
  std::array<Vec3, 4> sum;
  std::array<int, 4> n{};
  sum.fill(Vec3::Zero());
  const std::size_t middle = window.size() / 2;
  const auto take = [&](std::size_t i, const Quat& q_middle_i) {
    const std::size_t quarter = 4 * i / window.size();
    sum[quarter] += q_middle_i * window[i].acc_mps2;
    ++n[quarter];
  };
  Quat q = Quat::Identity();
  for (std::size_t i = middle; i < window.size(); ++i) {
    take(i, q);
    q = (q * exp_quat(window[i].gyr_radps * dt_s)).normalized();
  }
  q = Quat::Identity();
  for (std::size_t i = middle; i-- > 0;) {
    q = (q * exp_quat(-window[i].gyr_radps * dt_s)).normalized();
    take(i, q);
  }
  for (std::size_t k = 0; k < 4; ++k) sum[k] /= std::max(1, n[k]);
  return sum;
}

}  // namespace

double coefficient_of_variation(std::span<const MotionSample> window, double counts_per_g,
                                double zero_counts) noexcept {
  double sum = 0.0, sq = 0.0;
  for (const auto& s : window) {
    const double counts = zero_counts + counts_per_g * s.acc_mps2.x() / kStandardGravity_mps2;
    sum += counts;
    sq += counts * counts;
  }
  const double n = static_cast<double>(window.size()), mean = sum / n;
  return std::sqrt(std::max(0.0, sq / n - mean * mean)) / std::abs(mean);
}

double three_axis_variance(std::span<const MotionSample> window) noexcept {
  const Vec3 mean = mean_force(window);
  double sum = 0.0;
  for (const auto& s : window) sum += (s.acc_mps2 - mean).squaredNorm();
  return sum / static_cast<double>(window.size());
}

double shoe(std::span<const MotionSample> window, double gravity_mps2, double acc_sd, double gyr_sd) noexcept {
  const Vec3 down = gravity_mps2 * mean_force(window).normalized();
  double sum = 0.0;
  for (const auto& s : window)
    sum += (s.acc_mps2 - down).squaredNorm() / (acc_sd * acc_sd) + s.gyr_radps.squaredNorm() / (gyr_sd * gyr_sd);
  return sum / static_cast<double>(window.size());
}

double derotated_quarters(std::span<const MotionSample> window, double dt_s) noexcept {
  return calib::SlowChange(turned_quarters(window, dt_s)).squared();
}

}  // namespace stillpoint::bench

/// How far the measurements have pulled the attitude away from where the gyroscope carried it. (A28) and (A33) of
/// docs/math/attitude.md.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::fusion {

/// A pull larger than the filter's own variances explain is a mistake, of the gyroscope or of whatever pulled: a car
/// that accelerates, a field that bends. Which of the two nobody knows, so the attitude may be off by as much.
class Pull {
 public:
  /// One correction about the world's axes [rad], and the variance that the filter expected of it.
  void add(const Vec3& turned_rad, const Vec3& expected_rad2) noexcept {
    vec(turned_rad_) += turned_rad;
    vec(expected_rad2_) += expected_rad2;
    vec(lately_rad_) += turned_rad;
  }
  /// Variance that a surprise has added: what it lets in is not explained by it.
  void doubt(int axis, double variance_rad2) noexcept {
    expected_rad2_[static_cast<std::size_t>(axis)] -= variance_rad2;
  }
  /// What was long ago has been made good by what came since. `offset_radps` is the gyroscope's that is in use: what
  /// has lately been learnt of it has turned the attitude too (A33).
  void pass(const Vec3& offset_radps, const Mat3& R_world_body, double time_s) noexcept {
    const double keep = std::exp(-time_s / kMemory_s);
    vec(turned_rad_) *= keep;
    vec(expected_rad2_) *= keep * keep;
    if (!has_offset_) vec(offset_radps_) = offset_radps;
    has_offset_ = true;
    const Vec3 learnt = offset_radps - vec(offset_radps_);
    vec(lately_rad_) -= time_s * (R_world_body * learnt);
    vec(lately_rad_) *= std::exp(-time_s / kLately_s);
    vec(offset_radps_) += std::min(1.0, time_s / kLately_s) * learnt;
  }
  /// The world's axes are turned.
  void turn_world(const Mat3& by) noexcept {
    vec(turned_rad_) = by * Vec3(vec(turned_rad_));
    vec(lately_rad_) = by * Vec3(vec(lately_rad_));
  }
  /// Gravity at rest has shown the tilt itself.
  void forget_tilt() noexcept {
    turned_rad_[0] = turned_rad_[1] = expected_rad2_[0] = expected_rad2_[1] = 0.0;
    lately_rad_ = {};
    has_offset_ = false;
  }
  /// Another heading has been taken.
  void forget_heading() noexcept { turned_rad_[2] = expected_rad2_[2] = 0.0; }

  /// What is not explained [rad^2, world axes]: the square of the pull, shrunk as (A16) does, and a share of what the
  /// tilt has lately been pulled by, expected or not: a vehicle that accelerates looks like an offset that is being
  /// learnt. No angle is off by more than any.
  [[nodiscard]] Mat3 unexplained_rad2() const noexcept {
    const auto& d = turned_rad_;
    const auto& e = expected_rad2_;
    const auto surprise = [&d, &e](std::size_t i) { return d[i] * d[i] / std::max(e[i], kLeast_rad2); };
    const double heading = share(1.0, surprise(2));
    const Vec3 lately(lately_rad_[0], lately_rad_[1], 0.0);
    const double of_vehicle = kInVehicle * (1.0 - kOfAHand_rad2 / std::max(lately.squaredNorm(), kOfAHand_rad2));
    Mat3 doubt = square(share(2.0, surprise(0) + surprise(1)), Vec3(d[0], d[1], 0.0)) + square(of_vehicle, lately);
    doubt(2, 2) = heading * std::min(kAny_rad2, d[2] * d[2]);
    return doubt;
  }

 private:
  static constexpr double kMemory_s = 120.0;  ///< so long a lift or a train keeps a body
  static constexpr double kLately_s = 20.0;   ///< so long a train accelerates
  static constexpr double kInVehicle = 0.15;  ///< so many of the bodies that nobody has seen at rest are in a vehicle
  static constexpr double kOfAHand_rad2 = 9e-4;  ///< what any motion pulls by: 1.7 degrees
  static constexpr double kUsual = 4.0;          ///< times its mean: two deviations are no surprise
  static constexpr double kLeast_rad2 = 1e-6;
  static constexpr double kAny_rad2 = std::numbers::pi * std::numbers::pi / 3.0;  ///< any angle
  static double share(double degrees, double chi2) noexcept {
    return chi2 > 0.0 ? std::max(0.0, 1.0 - kUsual * degrees / chi2) : 0.0;
  }
  static Mat3 square(double share, const Vec3& turned_rad) noexcept {
    return share * std::min(1.0, kAny_rad2 / turned_rad.squaredNorm()) * turned_rad * turned_rad.transpose();
  }
  Array3 turned_rad_{}, expected_rad2_{};
  Array3 lately_rad_{}, offset_radps_{};
  bool has_offset_ = false;
};

static_assert(std::is_trivially_copyable_v<Pull>);

}  // namespace stillpoint::fusion

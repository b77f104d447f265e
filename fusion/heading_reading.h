/// What one magnetic field in world axes says of the heading, and what that hangs on. (A10), (A17).
#pragma once
#include <cmath>
#include <numbers>

#include "core/types.h"

namespace stillpoint::fusion {

/// One magnetic heading against the filter's.
struct HeadingReading {
  double error_rad = 0.0;                          ///< truth less estimate
  Eigen::Vector2d lean = Eigen::Vector2d::Zero();  ///< by the tilt about east and north
  Vec3 iron = Vec3::Zero();                        ///< by the error of the hard iron, rad/uT
  double field_variance_rad2 = 0.0;                ///< by the visible part of a disturbance
  double white_variance_rad2 = 0.0;                ///< by the magnetometer's own noise

  /// Magnetic north lies at pi/2 - declination from east; the field seems turned from it by minus the error.
  [[nodiscard]] static double error(const Vec3& field_uT, double declination_rad) noexcept {
    return std::remainder(0.5 * std::numbers::pi - declination_rad - std::atan2(field_uT.y(), field_uT.x()),
                          2.0 * std::numbers::pi);
  }

  [[nodiscard]] static HeadingReading of(const Vec3& field_uT, const Mat3& R_world_body,
                                         double declination_rad) noexcept {
    const double horizontal2 = field_uT.head<2>().squaredNorm();
    HeadingReading reading;
    reading.error_rad = error(field_uT, declination_rad);
    // A tilt error leans the vertical field into the horizontal plane: the heading turns with the tilt about north.
    reading.lean = field_uT.z() / horizontal2 * field_uT.head<2>();
    reading.iron = (field_uT.y() * R_world_body.row(0) - field_uT.x() * R_world_body.row(1)) / horizontal2;
    return reading;
  }
};

}  // namespace stillpoint::fusion

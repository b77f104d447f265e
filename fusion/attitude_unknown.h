/// What nobody knows of a motion while a sensor is silent. Internal to fusion.
#pragma once
#include <numbers>

#include "core/units.h"

namespace stillpoint::fusion {

inline constexpr double kUnknownRate_radps = 2.0;  ///< rate of a body whose gyroscope is absent: moved by hand
inline constexpr double kUnknownForce_mps2 = 5.0;  ///< acceleration while the accelerometer is absent
inline constexpr double kUnknownTime_s = 0.2;      ///< after which either is another one
inline constexpr double kUnknownHeading_rad2 = std::numbers::pi * std::numbers::pi / 3.0;  ///< any heading
inline constexpr double kLostTilt_rad = 0.5;   ///< beyond it the filter's straight lines end: down is taken anew
inline constexpr double kStartTilt_rad = 0.1;  ///< a start may hold 1 m/s^2 of motion
inline constexpr double kFalling_mps2 = 0.1 * kStandardGravity_mps2;  ///< below it there is no down
inline constexpr double kRegained_rad = 0.05;                         ///< tilt that is known again after a pause

/// Variance that a step without gyroscope adds to the rotation, and one without accelerometer to the velocity.
inline double unknown_turn2(double dt_s) {
  return kUnknownRate_radps * kUnknownRate_radps * 2.0 * kUnknownTime_s * dt_s;
}
inline double unknown_speed2(double dt_s) {
  return kUnknownForce_mps2 * kUnknownForce_mps2 * 2.0 * kUnknownTime_s * dt_s;
}

}  // namespace stillpoint::fusion

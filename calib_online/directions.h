/// Directions spread evenly over the sphere: over them an error that depends on direction is averaged.
#pragma once
#include <cmath>

#include "core/types.h"

namespace stillpoint::calib {

/// The k-th of n unit vectors on a spiral by the golden angle, from the top of the sphere to its bottom.
inline Vec3 even_direction(int k, int n) noexcept {
  constexpr double kGoldenAngle_rad = 2.399963229728653;  // pi (3 - sqrt(5))
  const double z = 1.0 - (2.0 * k + 1.0) / n;
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(kGoldenAngle_rad * k), r * std::sin(kGoldenAngle_rad * k), z};
}

}  // namespace stillpoint::calib

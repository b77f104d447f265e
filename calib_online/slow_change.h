/// How the force of a window changes slowly: docs/math/rest.md, R3.
#pragma once
#include <array>
#include <cmath>

#include "core/types.h"

namespace stillpoint::calib {

/// How four quarter means in a row change, in an orthonormal basis: R3. The third contrast is left out. A motion that
/// shows there and not here has more than one period inside the window: its mean, which is what harms, is near zero.
struct SlowChange {
  Vec3 slope, curvature;  ///< unit of the means
  explicit SlowChange(const std::array<Vec3, 4>& m) noexcept
      : slope((3.0 * (m[3] - m[0]) + (m[2] - m[1])) / std::sqrt(20.0)), curvature(0.5 * (m[0] - m[1] - m[2] + m[3])) {}
  [[nodiscard]] double squared() const noexcept { return slope.squaredNorm() + curvature.squaredNorm(); }
};

}  // namespace stillpoint::calib

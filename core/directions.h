/// Directions against each other: the angle between two, the rotation nearest to what takes many to their counterparts.
#pragma once
#include <cmath>

#include "core/types.h"

namespace stillpoint {

[[nodiscard]] inline double angle_rad(const Vec3& a, const Vec3& b) noexcept {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// The shortest turn that takes the direction of `from` to that of `to`; of opposite ones about some axis across.
[[nodiscard]] Quat turn_between(const Vec3& from, const Vec3& to);

/// The orthogonal matrix of this determinant, 1 or -1, that is nearest to M in the Frobenius norm. Of M = sum a_i b_i'
/// it takes the b_i nearest to the a_i (Wahba 1965; by SVD: Markley 1988).
[[nodiscard]] Mat3 nearest_orthogonal(const Mat3& M, double determinant = 1.0);

/// By how much M stretches its principal directions, the most first.
[[nodiscard]] Vec3 singular_values(const Mat3& M);

/// The most by which M stretches or shrinks a vector, as a factor: 1 of a turn, infinite of a singular M.
[[nodiscard]] double distortion(const Mat3& M);

}  // namespace stillpoint

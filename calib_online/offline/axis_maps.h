/// Signed permutations of the axes: the ways in which a sensor usually sits on a body. A map takes vectors in the
/// sensor's axes to the frame's, so its rows say which sensor axis each axis of the frame is.
#pragma once
#include <span>

#include "core/types.h"

namespace stillpoint::calib {

/// The 24 that do not mirror; the other 24 are their negatives.
[[nodiscard]] std::span<const Mat3> axis_maps() noexcept;

/// The nearest to an orthogonal matrix; it mirrors where that does.
[[nodiscard]] Mat3 nearest_axis_map(const Mat3& orthogonal) noexcept;

struct Unmirrored {
  int sensor_axis = 0;           ///< that reads with the wrong sign
  Mat3 map = Mat3::Identity();   ///< of the sensor once it reads right
  Mat3 turn = Mat3::Identity();  ///< the same of the orthogonal matrix itself
};
/// Each of the three axes may be the wrong one; taken is that which leaves the map nearest to no turn at all.
/// Pre: det < 0.
[[nodiscard]] Unmirrored unmirrored(const Mat3& mirroring) noexcept;

}  // namespace stillpoint::calib

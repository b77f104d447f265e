/// What one log is of another, row by row: the linear map between them, and what it says of their units and axes.
#pragma once
#include <string>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// y ~ offset + A x over the rows inside.
struct LinearMap {
  Mat3 A = Mat3::Identity();
  Series3 left;
  Mat3 scatter = Mat3::Identity();  ///< of x
};

[[nodiscard]] LinearMap linear_map(const Series3& x, const Series3& y, const Mask& outside);

/// The map of the rows that it fits best for how much they move: half of them, so that a part of another motion does
/// not bend it, nor a rest, which says nothing of it.
[[nodiscard]] LinearMap map_of_the_better_half(const Series3& x, const Series3& y, const Mask& outside);

/// Whether the two mean the same by a number: units first, then axes, both by what moves. Empty where they do.
[[nodiscard]] std::string difference(Sensor k, const LinearMap& map);

}  // namespace stillpoint::diag

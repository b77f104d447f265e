#include "pipeline/full_scale.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::pipeline {
namespace {

constexpr int kPlateaus = 3;       ///< one could be chance
constexpr double kRunUp = 0.01;    ///< part of the rail: what came in faster does not stop at once by itself
constexpr double kStride = 50.0;   ///< lattice steps: a smooth motion creeps to its turn, it does not jump there
constexpr double kAtRail = 0.999;  ///< rounding of the source, and what interpolation leaves of it
constexpr double kBeyondRail = 1.003;
/// Of the smallest full scale: readings that arithmetic has been done with differ by rounding, no lattice is as fine.
constexpr double kRounding = 1e-6;

}  // namespace

bool FullScale::at_rail(Axis& axis, double reading, bool others_live) noexcept {
  const double step = std::abs(reading - axis.last) > kRounding * smallest_ ? reading - axis.last : 0.0;
  Rail& rail = axis.rails[reading > 0.0 ? 1 : 0];
  const double size = std::abs(reading);
  if (step == 0.0 && others_live) {
    if (axis.same++ == 0) axis.run_up = std::abs(axis.step);
  } else if (step != 0.0) {
    axis.same = 0;
    rail.counted = false;
    axis.least = axis.least == 0.0 ? std::abs(step) : std::min(axis.least, std::abs(step));
  }
  axis.step = step;
  axis.last = reading;
  if (size > kBeyondRail * rail.value && rail.value > 0.0) rail = {};  // it was none
  const double run_up = size >= smallest_ ? kRunUp * size : std::max(kRunUp * size, kStride * axis.least);
  const bool plateau = axis.same >= 1 && axis.run_up > run_up;
  if (plateau && !rail.counted) {
    if (size < kAtRail * rail.value) return false;  // a plateau below the rail is something else
    rail.plateaus = static_cast<std::uint8_t>(std::min(rail.plateaus + 1, kPlateaus));
    rail.value = std::max(rail.value, size);
    rail.counted = true;
  }
  return rail.plateaus >= kPlateaus && size >= kAtRail * rail.value;
}

bool FullScale::at_rail(const Array3& reading) noexcept {
  bool any = false;
  const auto moved = [&](std::size_t i) { return std::abs(reading[i] - last_[i]) > kRounding * smallest_; };
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    any |= at_rail(axes_[i], reading[i], moved(j) || moved(k));
  }
  last_ = reading;
  return any;
}

}  // namespace stillpoint::pipeline

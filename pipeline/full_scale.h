/// The full scale of a triad found from its readings: a signal that runs up to a value and stays there to the last bit
/// has met the sensor's rail. What the configuration states holds beside it.
#pragma once
#include <array>
#include <cstdint>
#include <type_traits>

#include "core/types.h"

namespace stillpoint::pipeline {

/// Both ends of the three axes. A rail is believed once a few plateaus lie at it, and forgotten when a reading passes
/// it. Plain state; a few comparisons a sample.
class FullScale {
 public:
  /// `smallest` is the smallest full scale that such sensors are commonly sold with: below it a plateau may be the
  /// lattice's at the turn of a slow motion, and counts only when a stride of many lattice steps led to it.
  explicit FullScale(double smallest) noexcept : smallest_(smallest) {}

  /// True when an axis of this reading sits at a rail that is known by now.
  bool at_rail(const Array3& reading) noexcept;

 private:
  struct Rail {
    double value = 0.0;  ///< magnitude
    std::uint8_t plateaus = 0;
    bool counted = false;  ///< the present plateau has been
  };
  struct Axis {
    std::array<Rail, 2> rails;  ///< below zero, above
    double last = 0.0, step = 0.0;
    int same = 0;         ///< readings in a row that equal the one before
    double run_up = 0.0;  ///< the step that led to them
    double least = 0.0;   ///< smallest step so far: the lattice's
  };
  bool at_rail(Axis& axis, double reading, bool others_live) noexcept;

  double smallest_;
  std::array<Axis, 3> axes_{};
  Array3 last_{};
};

static_assert(std::is_trivially_copyable_v<FullScale>);

}  // namespace stillpoint::pipeline

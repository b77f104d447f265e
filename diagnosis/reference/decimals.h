/// What the decimals of the file leave of a reference that is arithmetic otherwise. At rest the same digits come out
/// row after row and the reference looks perfect; in motion its rounding is noise, and differences multiply it by the
/// rate, and by its square: a tenth of a micrometre is 0.004 m/s^2 at 200 rows a second.
#pragma once
#include "io/recording.h"

namespace stillpoint::diag {

/// Standard deviation per axis, of derivative() and second_derivative() of the pose as it stands in the file.
struct RoundingNoise {
  double rate_radps = 0.0;
  double acceleration_mps2 = 0.0;
};

/// Rounding to a step is white and even over the step where the value moves by more than that; a value that does not
/// has none.
[[nodiscard]] RoundingNoise rounding_noise(const io::Recording& recording, double dt_s);

}  // namespace stillpoint::diag

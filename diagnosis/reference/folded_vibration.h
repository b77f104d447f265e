/// Vibrations of the body beyond half the rate of the rows. The reference holds the true pose of every row, but whoever
/// differentiates it takes them for the frequency to which the rows fold them: the body turns at 120 Hz, the reference
/// of 100 rows a second at 20, and a sixth of the rate is predicted.
#pragma once
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// A line of the residual is the body's where the reference moves there, too, on the same axes and as many times
/// weaker as a fold makes it: f_n / f for the rate, (f_n / f)^2 for the acceleration, f_n = n fs +- f. The prediction
/// is made as much larger, and a notice says so. Needs `predicted`, `reading` and `muted`.
void unfold_vibrations(Signals& s);

}  // namespace stillpoint::diag

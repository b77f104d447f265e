/// How well the numbers inside of laws are known: time constants, moments, thresholds.
#pragma once
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// A coefficient and the time constant of its law are known together only: the tangent of each inner number joins the
/// columns, so that what it could still move widens the deviations of the coefficients. A step or a backlash answers
/// its number by jumps: in the end the tangents of a discovered law span what its numbers may be off by. Pre: `out` is
/// fitted. Fills in `sd` and `inner_sd`.
void free_inner_numbers(const SensorSearch& search, const Target& t, Finished& out);

}  // namespace stillpoint::diag

/// A second look at slow rows. Beside a camera the residual of accelerometer and gyroscope holds derivatives of the
/// camera's errors: metres per second squared from row to row, and next to nothing of it over seconds. An
/// autoregression over a third of a second does not know that, and laws of what is slow - a temperature, a current, an
/// offset that steps - drown in it.
#pragma once
#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// Weighted means over 0.3 s, one every 0.1 s (of more than 200 s so many that 2000 are left), for accelerometer and
/// gyroscope; none where they cannot show more:
/// beside an exact reference or a log, or of rows that are as slow. The weights are those of a quadratic spline: they
/// let less than a hundredth of what is faster than 10 Hz pass for something slow, where plain means let derivatives
/// pass.
[[nodiscard]] std::optional<Signals> slow_rows(const Signals& s);

/// Of what was found there the laws that something slow drives - a temperature, a current, time - and that predict what
/// they were not fitted on. Means know little of what moves with the body, and nothing of clocks.
void keep_what_is_slow(EngineResult& in_slow_rows);

/// Whether a sensor's laws explain clearly more of the slow rows than of all rows, by another cause than is seen there,
/// and it has no clock to speak of.
[[nodiscard]] bool is_seen_better(const EngineResult& in_slow_rows, const EngineResult& in_all_rows, Sensor sensor);

}  // namespace stillpoint::diag

/// Numbers that a part can have: what is larger, smaller or sharper than parts are is another cause's doing.
#pragma once
#include "diagnosis/reference/selection.h"

namespace stillpoint::diag {

/// Where the response is undone in the sensor's own reading, twice differentiated noise is in the law as well as in the
/// residual. White noise n up to `band` correlates with its own part -n'' / (2 pi f_n)^2 of a resonance by
/// sd^2 4 dt band^3 / (3 f_n^2) a row (half of it beyond the band, where `low_pass` falls), always with the sign of a
/// resonance.
[[nodiscard]] bool is_its_own_noise(const Signals& s, const SensorSearch& search, const Found& law);

/// A number beyond anything that parts have is another law's doing, however well it fits.
[[nodiscard]] bool possible(const Signals& s, const SensorSearch& search, const Found& law);

/// Whether beside it the numbers that were there before become others: one that was found does several times as much,
/// or the matrix is another sensor's. Each takes back what the other does, in a motion in which they are nearly one.
[[nodiscard]] bool moves_the_others(const SensorSearch& search, const Fit& before, const Fit& beside);

/// Whether a law does no more, where it acts, than what the form of a filter before it may be off by: none is the first
/// or second order that it is modelled as to less than half a percent.
[[nodiscard]] bool is_of_a_filters_form(const SensorSearch& search, const Found& law);

/// Powers of ten by which the largest number of a linear law of the catalogue, or the rate of a clock, lies below what
/// parts usually have: a lateness of 50 us grows as well as it stays. 0 where it does not, or where the catalogue gives
/// no usual size.
[[nodiscard]] double decades_below_usual(const SensorSearch& search, const Found& law);

}  // namespace stillpoint::diag

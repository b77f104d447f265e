/// Which explanation is stated: the one that needs least belief among those that explain as much, and a law by its name
/// only while nothing freer on the same driver explains more (docs/decisions/044-adequacy-of-a-law.md).
#pragma once
#include "diagnosis/reference/judge.h"

namespace stillpoint::diag {

inline constexpr const char* kPlainOffset = "unknown:offset(t)";

/// The best that is not beaten by what needs less belief: a name of the catalogue before a product of drivers that is
/// no better, a plain offset before a law that is local in time and explains no more, the lever arm before the size
/// effect that contains it, a body-fixed step before a soft one where the current that could switch it was not
/// recorded. A name that the recording cannot tell from a known form without a name gives way to that. `sorted`: by net
/// gain. None when there is none.
[[nodiscard]] std::optional<Found> best_explanation(const std::vector<Found>& sorted, bool current_recorded);

/// `law`, or the free function of its driver that explains more than it does, and more than it does together with any
/// other law of the library on that driver. Such a function is answered as unknown, with its driver.
[[nodiscard]] Found adequate(const Signals& s, const SensorSearch& search, const Judge& judge, Found law);

/// A model after which more is left than before has fitted the colour of a camera's noise, not the sensor.
[[nodiscard]] bool leaves_less(const SensorSearch& search, const Found& law);

/// Whether beside it nothing is left but the sensor's own noise. What an inexact model of a large effect leaves over is
/// no law, and leaves some of it. Only beside an exact reference.
[[nodiscard]] bool leaves_only_noise(const Signals& s, const SensorSearch& search, const Found& law);

}  // namespace stillpoint::diag

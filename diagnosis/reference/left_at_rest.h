/// What a finished model leaves within rests. Nothing moves there, and whatever a reference errs by is one constant a
/// rest: what still wanders or swings is physics without a model, however well a noise model may take it up.
#pragma once
#include <optional>
#include <string>

#include "diagnosis/reference/evidence.h"
#include "diagnosis/result.h"

namespace stillpoint::diag {

/// A finding without a model, `unknown:u(t)`; none where the sensor's noise accounts for all that wanders.
[[nodiscard]] std::optional<Finding> wanders_at_rest(const Signals& s, const SensorSearch& search,
                                                     const Finished& finished);

/// Words for a narrow band that stands far over the configured noise. No finding: nothing here tells a vibration that
/// the reference cannot see from a line of the sensor.
[[nodiscard]] std::optional<std::string> swings_at_rest(const Signals& s, const SensorSearch& search,
                                                        const Finished& finished);

}  // namespace stillpoint::diag

/// A driver that carries the same noise as the residual would be taken for a filter. It is therefore used only in the
/// band where motion stands far above its noise. The noise is what the signal shows at rest or, without one, near the
/// highest frequencies.
#pragma once
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// Highest frequency up to which the power in motion exceeds that at rest by `ratio`, in [lowest, highest].
/// `highest` when the body hardly moved.
[[nodiscard]] double motion_band_hz(const Series3& x, const Mask& rest, double dt_s, double ratio, double lowest_Hz,
                                    double highest_Hz);

}  // namespace stillpoint::diag

/// Delays and filters that are switched on and off.
#pragma once
#include "diagnosis/reference/timing.h"

namespace stillpoint::diag {

/// The law acting within the window only.
[[nodiscard]] TimingLaw in_window(TimingLaw law, const Window& window);

}  // namespace stillpoint::diag

/// Rows taken at random times, beside what else is found.
#pragma once
#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// The time of each row again, without what the laws that were found do: until they are known a row's time takes what
/// lies along the derivative of it. False, and nothing is done, without a jitter or a law.
[[nodiscard]] bool time_rows_again(Signals& s, const EngineResult& found);

}  // namespace stillpoint::diag

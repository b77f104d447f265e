/// Rows taken at random times, beside what else is found.
#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/reference/engine.h"

namespace stillpoint::diag {

/// A clock that is wrong as well, or a row that was lost, hides a jitter until it is found: rows are late by turns
/// then, and not at random. True, and the rows are timed, where one is found now.
[[nodiscard]] bool find_jitter_beside(const EngineResult& found, Signals& s, const sim::SimulationConfig& given,
                                      Answer& answer);

/// The time of each row again, without what the laws that were found do: until they are known a row's time takes what
/// lies along the derivative of it. False, and nothing is done, without a jitter or a law.
[[nodiscard]] bool time_rows_again(Signals& s, const EngineResult& found);

}  // namespace stillpoint::diag

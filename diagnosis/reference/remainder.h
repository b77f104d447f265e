/// What the finished model of a sensor says beside its findings: which numbers of the simulation are wrong, and what is
/// left in each channel.
#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// Adds to the configuration, the numbers set right and the residuals of `out`.
void report_remainder(const Signals& s, const SensorSearch& search, const Finished& finished, Answer& out);

}  // namespace stillpoint::diag

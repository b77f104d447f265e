/// Sharp lines that the readings show by themselves: beyond the band in which bodies move a camera's noise would cover
/// them, and means of neighbouring rows would weaken or fold them.
#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// Finds them in all rows, tells them, and takes them out of the residuals. `rows_merged`: of how many neighbours the
/// mean is taken afterwards; `without`: names that are not in the library this time.
void find_lines_in_readings(Signals& s, Eigen::Index rows_merged, const std::vector<std::string>& without,
                            Answer& answer);

}  // namespace stillpoint::diag

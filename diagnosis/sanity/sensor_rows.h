/// Sensors whose readings stand in rows of their own.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording.h"

namespace stillpoint::diag {

/// The recording with one row for every reading of the slower inertial sensor, the other interpolated to those rows,
/// and without the rows that hold the other alone: a logger that writes each sensor at its own stamps. A notice says
/// which. None where they share their rows.
[[nodiscard]] std::optional<io::Recording> with_inertial_on_rows(const io::Recording& recording,
                                                                 std::vector<std::string>& notices);

/// The recording with the field interpolated to the rows of the inertial sensors, and without the rows that hold a
/// field alone. A magnetometer slower than they are would be given readings it never took, with a noise that no noise
/// model expects: it stays away from their rows. A notice says which. None where the field has no rows of its own.
[[nodiscard]] std::optional<io::Recording> with_field_on_rows(const io::Recording& recording,
                                                              std::vector<std::string>& notices);

/// All of that: without single values that cannot be measurements (readings.h), each sensor on the rows of the slower
/// inertial one. None where nothing had to change.
[[nodiscard]] std::optional<io::Recording> readings_on_rows(const io::Recording& recording,
                                                            std::vector<std::string>& notices);

}  // namespace stillpoint::diag

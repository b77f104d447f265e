/// Rows as the rest of the diagnosis wants them: nothing in them that no sensor can have measured, and a row for every
/// sample that was lost.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording.h"

namespace stillpoint::diag {

/// The recording without single values that cannot be measurements - beyond any sensor, the same number filled into all
/// three axes, a temperature below any chamber's, a quaternion without unit length - each taken as not measured, with a
/// notice. Where a fifth of a column or more is like that it is left as it is: then it is a wrong unit. None when there
/// is nothing to take out.
[[nodiscard]] std::optional<io::Recording> without_false_values(const io::Recording& recording,
                                                                std::vector<std::string>& notices);

/// The recording with empty rows where time jumps, a second of them at most: differences and filters count rows, and
/// must not join what was apart. None when no row was lost.
[[nodiscard]] std::optional<io::Recording> with_lost_rows(const io::Recording& recording);

/// Seconds from row to row of the even clock behind the time stamps: the mean of the steps over which nothing was lost.
/// Where stamps are rounded or jitter, the median step is off by percents, and every derivative with it.
[[nodiscard]] double even_step_s(const io::Recording& recording);

}  // namespace stillpoint::diag

/// Rows and the seconds that the recording's own stamps give them: after a long break the two no longer go together.
#pragma once
#include <algorithm>

#include "diagnosis/reference/signals.h"

namespace stillpoint::diag {

/// From the start of the recording to the beginning of a row; of n: to the end of the last.
[[nodiscard]] inline double begin_of_row_s(const Signals& s, Eigen::Index row) {
  return row < s.n ? s.t_s[row] - s.t_s[0] : s.t_s[s.n - 1] - s.t_s[0] + s.dt_s;
}

/// The first row that begins at that time or later, half a row before being the same.
[[nodiscard]] inline Eigen::Index row_at(const Signals& s, double t_s) {
  const double* first = s.t_s.data();
  return std::lower_bound(first, first + s.n, t_s + s.t_s[0] - 0.5 * s.dt_s) - first;
}

}  // namespace stillpoint::diag

/// The time of one recording on the clock of another, from the rates or forces that both hold.
#pragma once
#include "diagnosis/reference/row_times.h"

namespace stillpoint::diag {

/// time on the log's clock = offset_s + (1 + drift) * time of the recording, both from their first rows.
struct Clocks {
  double offset_s = 0.0, drift = 0.0;
  double correlation = 0.0;  ///< of the norms, where they overlap
  double overlap_s = 0.0;
};

struct Course {
  Series3 x;
  RowTimes rows;
  [[nodiscard]] double end_s() const { return rows.at(x.rows() - 1); }
};

/// Coarse: by the correlation of the norms over every offset at which at least half of the shorter one overlaps. What
/// turns its axes or changes its unit does not matter.
[[nodiscard]] Clocks coarse_clocks(const Course& log, const Course& recording);

/// Fine: by least squares on the log's rate of change, beside a linear map of the log.
void refine_clocks(const Course& log, const Course& recording, Clocks& clocks);

/// The log at the times of the recording's rows; the end values beyond its ends.
[[nodiscard]] Series3 at_rows_of(const Course& recording, const Course& log, const Clocks& clocks);

}  // namespace stillpoint::diag

/// The time of one recording on the clock of another, from the rates or forces that both hold.
#pragma once
#include "diagnosis/reference/row_times.h"

namespace stillpoint::diag {

/// time on the log's clock = offset_s + (1 + drift) * time of the recording, both from their first rows.
struct Clocks {
  double offset_s = 0.0, drift = 0.0;
  double correlation = 0.0;  ///< of the norms, where they overlap
  double overlap_s = 0.0;
  double middle_s = 0.0;  ///< of the recording
  /// Standard deviations by leaving out each tenth of the recording: of the time at its middle, and of the drift.
  double middle_sd_s = 1.0, drift_sd = 1.0;

  [[nodiscard]] double at(double recording_s) const { return offset_s + (1.0 + drift) * recording_s; }
};

struct Course {
  Series3 x;
  RowTimes rows;  ///< stamped
  [[nodiscard]] double end_s() const { return rows.at(x.rows() - 1); }
};

/// Coarse: by the correlation of the norms over every offset at which at least half of the shorter one overlaps. What
/// turns its axes or changes its unit does not matter.
[[nodiscard]] Clocks coarse_clocks(const Course& log, const Course& recording);

/// Fine: by least squares on the log's rate of change, beside a linear map of the log.
void refine_clocks(const Course& log, const Course& recording, Clocks& clocks);

/// Fine, by how a reference turns; what it cannot tell from the clocks found by the readings is left at those. Where
/// the sensors are late, or their clock runs, this is the clock of the motion.
[[nodiscard]] Clocks clocks_of_reference(const Course& log, const Course& reference, const Clocks& by_readings);

/// Rows of which the log says nothing: before it begins, after it ends, and where it was not read for a few of its
/// steps, with as many readings beside them as a difference takes in.
[[nodiscard]] Mask unread_at_rows_of(const Course& recording, const Course& log, const Clocks& clocks);

/// The log at the times of the recording's rows; a straight line where it was not read, as unread_at_rows_of() says,
/// the end values beyond its ends.
[[nodiscard]] Series3 at_rows_of(const Course& recording, const Course& log, const Clocks& clocks, const Mask& unread);

}  // namespace stillpoint::diag

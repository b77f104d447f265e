/// The rows that are compared with a reference: one for every sample of an even clock, each with the reference beside
/// it, although a camera is often slower than the sensors and has empty fields, repeated values or rows of its own.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/recording.h"

namespace stillpoint::diag {

struct RowsWithReference {
  std::optional<io::Recording> changed;  ///< none: the recording as it was
  std::size_t rows_a_frame = 1;          ///< of a reference whose frames are slower
};

/// The recording with its lost rows put back as empty ones (with_lost_rows), without rows that hold a reference and no
/// reading of an inertial sensor, and with the reference interpolated between its frames: by Lagrange's polynomial
/// through up to eight on either side, as many as the differences take later. Values that repeat the row before while
/// the body turns are no frames, and neither are rows drawn as a line between two frames (frames_between.h,
/// frames_off_rows.h).
/// Where frames were lost, and at the ends, the fields stay empty. A notice where the reference is slower than the
/// rows.
[[nodiscard]] RowsWithReference rows_with_reference(const io::Recording& recording, std::vector<std::string>& notices);

}  // namespace stillpoint::diag

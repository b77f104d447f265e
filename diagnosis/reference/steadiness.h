/// Whether what was found is one law throughout, or something that changes while the recording lasts.
#pragma once
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {

/// A delay whose size changes from part to part of the recording, clearly and by much.
[[nodiscard]] bool delay_varies(const SensorSearch& search, std::size_t index, const Finished& finished);

/// Beside a delay for a while, which was found: whether some of `late`, what the same delay does to the whole
/// recording, is left. Then it is a piece of a latency that varies.
[[nodiscard]] bool is_late_elsewhere(const SensorSearch& search, const Series3& late);

/// A lever arm that is there from some moment on, or up to one: the sensor, or the reference's marker, was moved.
[[nodiscard]] bool was_moved(const Found& found, Eigen::Index rows);

}  // namespace stillpoint::diag

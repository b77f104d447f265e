/// Rows whose reference was not measured but drawn as a straight line between frames of a slower camera.
#pragma once
#include <vector>

#include "io/recording.h"

namespace stillpoint::diag {

struct DrawnRows {
  std::vector<bool> drawn;       ///< per row
  std::size_t rows_a_frame = 1;  ///< from one measured frame to the next
  std::size_t lost_rows = 0;     ///< that were no line between neighbouring frames, but one over lost ones
};

/// Found by their bends: a line has none, and a camera's own noise bends it at every frame. A line over several frames
/// of a noisy camera while the body moves was drawn over lost ones.
[[nodiscard]] DrawnRows rows_drawn_between_frames(const io::Recording& r);

}  // namespace stillpoint::diag

/// Frames of a camera that were drawn as lines onto rows with a clock of their own: 60 a second onto rows of 100.
#pragma once
#include <optional>
#include <vector>

#include "io/recording.h"

namespace stillpoint::diag {

struct FramesOffRows {
  double step_s = 0.0;                            ///< from frame to frame
  std::vector<double> turns_t_s, places_t_s;      ///< as Recording::t_s
  std::vector<Eigen::Vector4d> turns_world_body;  ///< never empty
  std::vector<Vec3> places_m;                     ///< empty: none, or they were not drawn as lines between these frames
};

/// Every row lies on a chord between two frames, so that there are more rows than unknown frames: their clock is the
/// one with which the chords meet all rows, and least squares give the frames. None where no even clock does so for the
/// attitudes, where there are less than 1.4 rows or 15 frames a second.
[[nodiscard]] std::optional<FramesOffRows> frames_off_rows(const io::Recording& recording);

}  // namespace stillpoint::diag

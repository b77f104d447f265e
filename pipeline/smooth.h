/// The attitude of a whole recording, each moment seen from both sides: what comes after a sample tells of it as well.
/// A fixed-interval smoother in two-filter form: Fraser and Potter, "The optimum linear smoother as a combination of
/// two optimum linear filters", IEEE Trans. Automatic Control 14 (1969); docs/math/attitude.md (A22).
#pragma once
#include <functional>
#include <vector>

#include "calib_online/online_calibrator.h"
#include "pipeline/stages.h"

namespace stillpoint::pipeline {

/// The sample of a row, asked for in order, twice.
using SampleAt = std::function<RawSample(std::size_t row)>;

struct Smoothed {
  std::vector<Processed> rows;  ///< every row that the stages let through, in the output frame
  Stages stages;                ///< of the pass that gave them, at its end
};

/// About 1.4 kB a row. The calibrator learns from the whole first, and what it knows at the end serves from the
/// beginning, unless the pass that stands on it states twice the deviations of the one that learnt on the way. Rate and
/// bias are those of the forward pass; a prediction is not made.
[[nodiscard]] Smoothed smooth(std::size_t rows, const SampleAt& sample, const StagesParams& params,
                              calib::OnlineCalibrator& calibrator);

/// The fusion of two estimates of one attitude, in one frame. `backward` knows the heading only where its word for it
/// is not kRelative; elsewhere its tilt alone counts.
[[nodiscard]] fusion::AttitudeEstimate fused(const fusion::AttitudeEstimate& forward,
                                             const fusion::AttitudeEstimate& backward) noexcept;

}  // namespace stillpoint::pipeline

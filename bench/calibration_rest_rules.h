/// The rest rules that are compared with the default (calib_online/rest_detector.h), as statistics of one window of
/// samples: small is rest. After Gietzelt et al., section 2.4 [coefficient of variation]; Skog, Handel, Nilsson,
/// Rantakokko, "Zero-velocity detection - an algorithm evaluation", IEEE TBME 2010, eq. (15) [SHOE/GLRT];
/// docs/math/rest.md, R1-R3.
#pragma once
#include <span>

#include "core/types.h"

namespace stillpoint::bench {

struct MotionSample {
  Vec3 acc_mps2 = Vec3::Zero();
  Vec3 gyr_radps = Vec3::Zero();  ///< bias removed
};

/// sd(x)/mean(x) of one axis of raw counts; the paper calls < 3e-3 over 2 s inactive. It depends on where the
/// converter's zero is: the same motion in other units gives another number.
[[nodiscard]] double coefficient_of_variation(std::span<const MotionSample> window, double counts_per_g,
                                              double zero_counts) noexcept;
/// Sum of the variances of the three axes, (m/s^2)^2.
[[nodiscard]] double three_axis_variance(std::span<const MotionSample> window) noexcept;
/// Mean of |f - g f/|f||^2 / sd_acc^2 + |w|^2 / sd_gyr^2.
[[nodiscard]] double shoe(std::span<const MotionSample> window, double gravity_mps2, double acc_sd,
                          double gyr_sd) noexcept;
/// Slow change of the quarter means after de-rotation to the middle, (m/s^2)^2.
[[nodiscard]] double derotated_quarters(std::span<const MotionSample> window, double dt_s) noexcept;

}  // namespace stillpoint::bench

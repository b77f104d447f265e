/// The magnetometer from a whole recording. In the daemon's order its first turns hardly count: how uneven the place is
/// is not known yet, nor is the gyroscope's matrix. Here the turns are gone through again when both are.
#pragma once
#include <span>

#include "calib_online/mag_learner.h"

namespace stillpoint::calib {

/// What the turns (of the gyroscope as it is known now) teach `at_first`.
[[nodiscard]] MagLearner learn_field(const MagLearner& at_first, std::span<const FieldTurn> turns, double gyr_matrix_sd,
                                     double gyr_bias_sd_radps);

}  // namespace stillpoint::calib

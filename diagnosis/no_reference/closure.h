/// Rates integrated over a bout of motion, and what is lost by knowing them at the recording's times only.
#pragma once
#include <vector>

#include "core/types.h"
#include "io/recording.h"

namespace stillpoint::diag::detail {

/// Rotation of the body from row `from` to row `to`, two neighbours in a recording read at every (to - from)-th row;
/// rates in rad/s, body. Third order: the rates before and after bend the straight line between the two, and the
/// coning term is that of two straight pieces.
[[nodiscard]] Quat turn_between(const io::Recording& recording, const std::vector<Vec3>& rate_radps, std::size_t from,
                                std::size_t to);

/// Error of the rotation between two rows: the integral over every second row tells how fast it grows with the step.
[[nodiscard]] double integration_error_rad(const io::Recording& recording, const std::vector<Vec3>& rate_radps,
                                           std::size_t from, std::size_t to);

}  // namespace stillpoint::diag::detail

/// How much of a concealed effect could be seen: the size in which sealed cases are drawn.
#pragma once
#include <cstdint>
#include <memory>

#include "simulation/config.h"
#include "simulation/motion.h"

namespace stillpoint::diag {

/// d': norm of what the effects of `config` change in the readings of the sensor that shows them best, whitened by the
/// noise of that sensor's residual - the reference's own noise is part of it -, after the best change of H and B is
/// taken off. Measured on twins that differ by the effects alone. Without a reference: what gyroscope, magnetometer and
/// rests can see of it among themselves, all that they do not know fitted beside; 0 where there is no rest.
[[nodiscard]] double whitened_d_prime(const sim::SimulationConfig& config,
                                      const std::shared_ptr<const sim::Motion>& motion, std::uint64_t seed);

}  // namespace stillpoint::diag

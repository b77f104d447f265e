/// Motions that are formulas over the whole time: turntable, tumbling, walking, vehicle, boat, drone.
#pragma once
#include <memory>

#include "simulation/motion.h"

namespace stillpoint::sim {

[[nodiscard]] std::unique_ptr<Motion> make_turntable(const MotionConfig& config, std::uint64_t seed);
[[nodiscard]] std::unique_ptr<Motion> make_tumble(const MotionConfig& config, std::uint64_t seed);
[[nodiscard]] std::unique_ptr<Motion> make_walking(const MotionConfig& config, std::uint64_t seed);
[[nodiscard]] std::unique_ptr<Motion> make_vehicle(const MotionConfig& config, std::uint64_t seed);
[[nodiscard]] std::unique_ptr<Motion> make_boat(const MotionConfig& config, std::uint64_t seed);
[[nodiscard]] std::unique_ptr<Motion> make_drone(const MotionConfig& config, std::uint64_t seed);

}  // namespace stillpoint::sim

/// From the sensor's own frame to the body and the world that the user asked for.
#pragma once
#include "core/types.h"
#include "fusion/attitude_estimate.h"

namespace stillpoint::pipeline {

enum class WorldFrame : std::uint8_t {
  kEnu,  ///< world x east, y north, z up; body x forward, y left, z up (REP-103)
  kNed,  ///< world x north, y east, z down; body x forward, y right, z down
};

struct OutputFrame {
  WorldFrame world = WorldFrame::kEnu;
  Quat q_body_sensor = Quat::Identity();  ///< the mounting: v_body = R v_sensor
};

/// The filter works in the sensor's frame; this gives its estimate for the body, in the wanted world.
[[nodiscard]] fusion::AttitudeEstimate in_frame(const fusion::AttitudeEstimate& sensor_in_enu,
                                                const OutputFrame& frame) noexcept;

/// The same for the readings, whose magnetometer and accelerometer stand beside the attitude on the ROS 2 topics.
[[nodiscard]] CalibratedSample in_frame(const CalibratedSample& of_sensor, const OutputFrame& frame) noexcept;

}  // namespace stillpoint::pipeline

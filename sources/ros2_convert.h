/// ROS 2 messages to readings: pure functions.
#pragma once
#include <stillpoint_idl/ros2.h>

#include "sources/reading.h"

namespace stillpoint::sources {

/// A covariance that begins with -1 says "not measured" (REP-145), zeros say "not known", any other states the noise:
/// the largest of its variances, as the filter knows no axes. `use_covariance` false: none of it is listened to. A
/// header without a stamp gives a reading without a time.
[[nodiscard]] Reading from_ros2(const sensor_msgs::msg::Imu& message, bool use_covariance) noexcept;
[[nodiscard]] Reading from_ros2(const sensor_msgs::msg::MagneticField& message, bool use_covariance) noexcept;

/// "/imu/data_raw" as DDS knows it: "rt/imu/data_raw".
[[nodiscard]] std::string dds_topic(const std::string& ros_topic);

}  // namespace stillpoint::sources

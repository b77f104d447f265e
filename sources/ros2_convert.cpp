#include "sources/ros2_convert.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::sources {
namespace {

constexpr double kMicroTeslaPerTesla = 1e6;

void put(const geometry_msgs::msg::Vector3& in, double to_si, SamplePart part, Array3& to, RawSample& sample) noexcept {
  const Array3 values{in.x() * to_si, in.y() * to_si, in.z() * to_si};
  if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); })) return;
  to = values;
  sample.has = static_cast<std::uint8_t>(sample.has | part);
}

Reading stamped(const std_msgs::msg::Header& header) noexcept {
  Reading out;
  const auto& stamp = header.stamp();
  out.sample.t_ns = std::int64_t{stamp.sec()} * 1'000'000'000 + stamp.nanosec();
  out.has_time = out.sample.t_ns != 0;
  return out;
}

}  // namespace

Reading from_ros2(const sensor_msgs::msg::Imu& message, bool use_covariance) noexcept {
  Reading out = stamped(message.header());
  const auto measured = [use_covariance](const auto& covariance) { return !use_covariance || covariance[0] != -1.0; };
  if (measured(message.linear_acceleration_covariance()))
    put(message.linear_acceleration(), 1.0, kAcc, out.sample.acc_mps2, out.sample);
  if (measured(message.angular_velocity_covariance()))
    put(message.angular_velocity(), 1.0, kGyr, out.sample.gyr_radps, out.sample);
  return out;
}

Reading from_ros2(const sensor_msgs::msg::MagneticField& message) noexcept {
  Reading out = stamped(message.header());
  put(message.magnetic_field(), kMicroTeslaPerTesla, kMag, out.sample.mag_uT, out.sample);
  return out;
}

std::string dds_topic(const std::string& ros_topic) {
  return "rt/" + ros_topic.substr(!ros_topic.empty() && ros_topic[0] == '/' ? 1 : 0);
}

}  // namespace stillpoint::sources

#include "sources/ros2_convert.h"

#include <algorithm>
#include <cmath>

namespace stillpoint::sources {
namespace {

constexpr double kMicroTeslaPerTesla = 1e6;
/// Deviations beyond these are no noise, but another unit or "do not use": five times gravity, 570 deg/s, twenty times
/// the Earth's field.
constexpr double kLargest_mps2 = 50.0, kLargest_radps = 10.0, kLargest_uT = 1000.0;

bool finite(double x) noexcept { return std::isfinite(x); }

void put(const geometry_msgs::msg::Vector3& in, double to_si, SamplePart part, Array3& to, RawSample& sample) noexcept {
  const Array3 values{in.x() * to_si, in.y() * to_si, in.z() * to_si};
  if (!std::all_of(values.begin(), values.end(), finite)) return;
  to = values;
  sample.has = static_cast<std::uint8_t>(sample.has | part);
}

/// The deviation that a covariance states, in our unit; 0: none.
double deviation(const Array9& covariance, double to_si, SamplePart part, double largest, Reading& out) noexcept {
  const auto [least, most] = std::minmax({covariance[0], covariance[4], covariance[8]});
  const auto odd = std::find_if_not(covariance.begin(), covariance.end(), finite);
  const double sd = to_si * std::sqrt(std::max(0.0, most));
  if (odd == covariance.end() && least >= 0.0 && sd <= largest) return sd;
  out.refused_part = part;
  out.refused_variance = odd != covariance.end() ? *odd : least < 0.0 ? least : most;
  return 0.0;
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
  const auto& of_acc = message.linear_acceleration_covariance();
  const auto& of_gyr = message.angular_velocity_covariance();
  if (measured(of_acc)) put(message.linear_acceleration(), 1.0, kAcc, out.sample.acc_mps2, out.sample);
  if (measured(of_gyr)) put(message.angular_velocity(), 1.0, kGyr, out.sample.gyr_radps, out.sample);
  if (use_covariance && out.sample.holds(kAcc)) out.noise.acc_mps2 = deviation(of_acc, 1.0, kAcc, kLargest_mps2, out);
  if (use_covariance && out.sample.holds(kGyr)) out.noise.gyr_radps = deviation(of_gyr, 1.0, kGyr, kLargest_radps, out);
  return out;
}

Reading from_ros2(const sensor_msgs::msg::MagneticField& message, bool use_covariance) noexcept {
  Reading out = stamped(message.header());
  const auto& covariance = message.magnetic_field_covariance();
  if (use_covariance && covariance[0] == -1.0) return out;
  put(message.magnetic_field(), kMicroTeslaPerTesla, kMag, out.sample.mag_uT, out.sample);
  if (use_covariance && out.sample.holds(kMag))
    out.noise.mag_uT = deviation(covariance, kMicroTeslaPerTesla, kMag, kLargest_uT, out);
  return out;
}

std::string dds_topic(const std::string& ros_topic) {
  return "rt/" + ros_topic.substr(!ros_topic.empty() && ros_topic[0] == '/' ? 1 : 0);
}

}  // namespace stillpoint::sources

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "io/dds_convert.h"

namespace stillpoint::io {
namespace {

constexpr double kTeslaPerMicrotesla = 1e-6;

void set_header(std_msgs::msg::Header& header, std::int64_t stamp_ns, const std::string& frame_id) {
  header.stamp().sec(static_cast<std::int32_t>(stamp_ns / 1'000'000'000));
  header.stamp().nanosec(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
  header.frame_id(frame_id);
}

geometry_msgs::msg::Vector3 vector3(const Array3& v, double scale = 1.0) {
  geometry_msgs::msg::Vector3 out;
  out.x(scale * v[0]);
  out.y(scale * v[1]);
  out.z(scale * v[2]);
  return out;
}

/// A field that was not measured has -1 in the first place of its covariance (REP-145).
void set_reading(bool measured, const Array3& value, const Array9& covariance, geometry_msgs::msg::Vector3& out,
                 Array9& out_covariance) {
  out = vector3(value);
  out_covariance = covariance;
  if (!measured) out_covariance[0] = -1.0;
}

/// diagnostic_msgs/DiagnosticStatus (REP-107).
std::uint8_t level_of(const DiagnosticsMessage& d) {
  constexpr std::uint8_t kOkLevel = 0, kWarn = 1, kError = 2, kStaleLevel = 3;
  if (d.status == AttitudeStatus::kStale) return kStaleLevel;
  const Health worst = d.health.worst();
  if (worst == Health::kFaulty || worst == Health::kAbsent) return kError;
  return d.status == AttitudeStatus::kOk && worst == Health::kOk && d.missing.empty() ? kOkLevel : kWarn;
}

}  // namespace

void to_ros2(const AttitudeMessage& attitude, const CalibratedSample& sample, const ReadingCovariances& covariances,
             const Ros2Header& header, sensor_msgs::msg::Imu& out) {
  set_header(out.header(), header.stamp_ns, header.frame_id);
  const auto& q = attitude.q_world_body_xyzw;
  out.orientation().x(q[0]);
  out.orientation().y(q[1]);
  out.orientation().z(q[2]);
  out.orientation().w(q[3]);
  out.orientation_covariance(attitude.orientation_covariance_rad2);
  if (attitude.status == AttitudeStatus::kInitializing) out.orientation_covariance()[0] = -1.0;
  set_reading(sample.holds(kGyr), attitude.rate_radps, covariances.gyr_radps_2, out.angular_velocity(),
              out.angular_velocity_covariance());
  set_reading(sample.holds(kAcc), sample.acc_mps2, covariances.acc_mps2_2, out.linear_acceleration(),
              out.linear_acceleration_covariance());
}

void to_ros2_raw(const RawSample& in, const ReadingCovariances& covariances, const Ros2Header& header,
                 sensor_msgs::msg::Imu& out) {
  set_header(out.header(), header.stamp_ns, header.frame_id);
  out.orientation() = {};
  out.orientation_covariance().fill(0.0);
  out.orientation_covariance()[0] = -1.0;
  set_reading(in.holds(kGyr), in.gyr_radps, covariances.gyr_radps_2, out.angular_velocity(),
              out.angular_velocity_covariance());
  set_reading(in.holds(kAcc), in.acc_mps2, covariances.acc_mps2_2, out.linear_acceleration(),
              out.linear_acceleration_covariance());
}

void to_ros2(const CalibratedSample& sample, const ReadingCovariances& covariances, const Ros2Header& header,
             sensor_msgs::msg::MagneticField& out) {
  set_header(out.header(), header.stamp_ns, header.frame_id);
  out.magnetic_field(vector3(sample.mag_uT, kTeslaPerMicrotesla));
  out.magnetic_field_covariance(covariances.mag_uT_2);
  for (double& x : out.magnetic_field_covariance()) x *= kTeslaPerMicrotesla * kTeslaPerMicrotesla;
}

void to_ros2(double temp_degC, const Ros2Header& header, sensor_msgs::msg::Temperature& out) {
  set_header(out.header(), header.stamp_ns, header.frame_id);
  out.temperature(temp_degC);
  out.variance(0.0);
}

void to_ros2(const DiagnosticsMessage& in, std::int64_t stamp_ns, diagnostic_msgs::msg::DiagnosticArray& out) {
  set_header(out.header(), stamp_ns, "");
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level(level_of(in));
  status.name("stillpointd: IMU");
  status.message(in.message);
  status.hardware_id(in.sensor_id);
  const auto add = [&status](const char* key, std::string value) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key(key);
    pair.value(std::move(value));
    status.values().push_back(pair);
  };
  const auto percentile = [&in](double p) {
    return fmt::format("{:.1f}", us(latency_percentile_ns(in.latency_counts, p)));
  };
  add("status", std::string(name(in.status)));
  add("rate_hz", fmt::format("{:.2f}", in.rate_hz));
  add("expected_rate_hz", fmt::format("{:.2f}", in.expected_rate_hz));
  add("samples", std::to_string(in.samples));
  add("gaps", std::to_string(in.gaps));
  add("dropped", std::to_string(in.dropped));
  add("clipped", std::to_string(in.clipped));
  add("refused", std::to_string(in.refused));
  for (const auto& [key, health] : {std::pair{"acc", in.health.acc}, std::pair{"gyr", in.health.gyr},
                                    std::pair{"mag", in.health.mag}, std::pair{"temp", in.health.temp}})
    add((std::string("health_") + key).c_str(), health.fault == Fault::kNone
                                                    ? std::string(name(health.state))
                                                    : fmt::format("{}: {}", name(health.state), name(health.fault)));
  add("source", in.source);
  add("missing", in.missing);
  add("latency_us_p50", percentile(0.5));
  add("latency_us_p99", percentile(0.99));
  add("latency_us_max", fmt::format("{:.1f}", us(in.latency_max_ns)));
  add("temperature_c", fmt::format("{:.2f}", in.temp_degC));
  add("last_refusal_reason", in.last_refusal);
  out.status().assign(1, status);
}

}  // namespace stillpoint::io

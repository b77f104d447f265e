#include "io/dds_convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace stillpoint::io {
namespace {

constexpr std::size_t kIdBound = 127, kTextBound = 255;
constexpr double kTeslaPerMicrotesla = 1e-6;

void to_wire(std::uint8_t sensor, const TriadCalibration& in, const std::string& reason, msg::SensorCalibration& out) {
  out.sensor(sensor);
  out.status(static_cast<std::uint8_t>(in.status));
  out.windows(in.windows);
  out.bias(in.bias);
  out.bias_per_K(in.bias_per_K);
  out.bias_per_K2(in.bias_per_K2);
  out.matrix(in.matrix);
  out.bias_covariance(in.bias_covariance);
  out.norm_sd(in.norm_sd);
  out.temp_ref_degC(in.temp_ref_degC);
  out.temp_min_degC(in.temp_min_degC);
  out.temp_max_degC(in.temp_max_degC);
  out.reason(reason.substr(0, kTextBound));
}

void from_wire(const msg::SensorCalibration& in, TriadCalibration& out, std::string& reason) {
  out.status = static_cast<CalibrationStatus>(in.status());
  out.windows = in.windows();
  out.bias = in.bias();
  out.bias_per_K = in.bias_per_K();
  out.bias_per_K2 = in.bias_per_K2();
  out.matrix = in.matrix();
  out.bias_covariance = in.bias_covariance();
  out.norm_sd = in.norm_sd();
  out.temp_ref_degC = in.temp_ref_degC();
  out.temp_min_degC = in.temp_min_degC();
  out.temp_max_degC = in.temp_max_degC();
  reason = in.reason();
}

double us(std::int64_t ns) { return 1e-3 * static_cast<double>(ns); }

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

}  // namespace

void to_wire(const AttitudeMessage& in, msg::Attitude& out) noexcept {
  out.t_ns(in.t_ns);
  out.t_arrival_ns(in.t_arrival_ns);
  out.t_publish_ns(in.t_publish_ns);
  out.sample_number(in.sequence);
  out.calibration_version(in.calibration_version);
  out.gaps(in.gaps);
  out.dropped(in.dropped);
  out.orientation_xyzw(in.q_world_body_xyzw);
  out.rate_radps(in.rate_radps);
  out.gyro_bias_radps(in.gyro_bias_radps);
  out.orientation_covariance_rad2(in.orientation_covariance_rad2);
  out.sigma_rpy_rad(in.sigma_rpy_rad);
  out.temperature_degC(in.temp_degC);
  out.at_rest(in.at_rest ? 1 : 0);
  out.status(static_cast<std::uint8_t>(in.status));
  out.heading_reference(static_cast<std::uint8_t>(in.heading_reference));
}

void from_wire(const msg::Attitude& in, AttitudeMessage& out) noexcept {
  out.t_ns = in.t_ns();
  out.t_arrival_ns = in.t_arrival_ns();
  out.t_publish_ns = in.t_publish_ns();
  out.sequence = in.sample_number();
  out.calibration_version = in.calibration_version();
  out.gaps = in.gaps();
  out.dropped = in.dropped();
  out.q_world_body_xyzw = in.orientation_xyzw();
  out.rate_radps = in.rate_radps();
  out.gyro_bias_radps = in.gyro_bias_radps();
  out.orientation_covariance_rad2 = in.orientation_covariance_rad2();
  out.sigma_rpy_rad = in.sigma_rpy_rad();
  out.temp_degC = in.temperature_degC();
  out.at_rest = in.at_rest() != 0;
  out.status = static_cast<AttitudeStatus>(in.status());
  out.heading_reference = static_cast<HeadingReference>(in.heading_reference());
}

void to_wire(const RawSample& in, std::int64_t t_arrival_ns, msg::RawImu& out) noexcept {
  out.t_ns(in.t_ns);
  out.t_arrival_ns(t_arrival_ns);
  out.sample_number(in.sequence);
  out.acc_mps2(in.acc_mps2);
  out.gyr_radps(in.gyr_radps);
  out.mag_uT(in.mag_uT);
  out.temperature_degC(in.temp_degC);
  out.has(in.has);
}

void from_wire(const msg::RawImu& in, RawSample& out) noexcept {
  out.t_ns = in.t_ns();
  out.sequence = in.sample_number();
  out.acc_mps2 = in.acc_mps2();
  out.gyr_radps = in.gyr_radps();
  out.mag_uT = in.mag_uT();
  out.temp_degC = in.temperature_degC();
  out.has = in.has();
}

void to_wire(const CalibrationMessage& in, msg::CalibrationState& out) {
  out.t_ns(in.snapshot.t_ns);
  out.version(in.snapshot.version);
  out.sensor_id(in.sensor_id.substr(0, kIdBound));
  to_wire(msg::SENSOR_ACC, in.snapshot.acc, in.reasons[0], out.sensors()[0]);
  to_wire(msg::SENSOR_GYR, in.snapshot.gyr, in.reasons[1], out.sensors()[1]);
  to_wire(msg::SENSOR_MAG, in.snapshot.mag, in.reasons[2], out.sensors()[2]);
}

void from_wire(const msg::CalibrationState& in, CalibrationMessage& out) {
  out.snapshot.t_ns = in.t_ns();
  out.snapshot.version = in.version();
  out.sensor_id = in.sensor_id();
  from_wire(in.sensors()[0], out.snapshot.acc, out.reasons[0]);
  from_wire(in.sensors()[1], out.snapshot.gyr, out.reasons[1]);
  from_wire(in.sensors()[2], out.snapshot.mag, out.reasons[2]);
}

void to_wire(const DiagnosticsMessage& in, msg::Diagnostics& out) {
  out.t_publish_ns(in.t_publish_ns);
  out.uptime_s(in.uptime_s);
  out.rate_hz(in.rate_hz);
  out.expected_rate_hz(in.expected_rate_hz);
  out.samples(in.samples);
  out.gaps(in.gaps);
  out.longest_gap_s(in.longest_gap_s);
  out.dropped(in.dropped);
  out.clipped(in.clipped);
  out.refused(in.refused);
  out.write_failures(in.write_failures);
  out.latency_p50_us(us(latency_percentile_ns(in.latency_counts, 0.50)));
  out.latency_p90_us(us(latency_percentile_ns(in.latency_counts, 0.90)));
  out.latency_p99_us(us(latency_percentile_ns(in.latency_counts, 0.99)));
  out.latency_p999_us(us(latency_percentile_ns(in.latency_counts, 0.999)));
  out.latency_max_us(us(in.latency_max_ns));
  out.temperature_degC(in.temp_degC);
  out.status(static_cast<std::uint8_t>(in.status));
  out.heading_reference(static_cast<std::uint8_t>(in.heading_reference));
  out.sensor_id(in.sensor_id.substr(0, kIdBound));
  out.message(in.message.substr(0, kTextBound));
  out.last_refusal(in.last_refusal.substr(0, kTextBound));
  out.latency_counts().assign(in.latency_counts.begin(), in.latency_counts.end());
}

void from_wire(const msg::Diagnostics& in, DiagnosticsMessage& out) {
  out.t_publish_ns = in.t_publish_ns();
  out.uptime_s = in.uptime_s();
  out.rate_hz = in.rate_hz();
  out.expected_rate_hz = in.expected_rate_hz();
  out.samples = in.samples();
  out.gaps = in.gaps();
  out.longest_gap_s = in.longest_gap_s();
  out.dropped = in.dropped();
  out.clipped = in.clipped();
  out.refused = in.refused();
  out.write_failures = in.write_failures();
  out.temp_degC = in.temperature_degC();
  out.status = static_cast<AttitudeStatus>(in.status());
  out.heading_reference = static_cast<HeadingReference>(in.heading_reference());
  out.sensor_id = in.sensor_id();
  out.message = in.message();
  out.last_refusal = in.last_refusal();
  out.latency_counts.fill(0);
  const auto& counts = in.latency_counts();
  std::copy_n(counts.begin(), std::min(counts.size(), kLatencyBuckets), out.latency_counts.begin());
  out.latency_max_ns = static_cast<std::int64_t>(1e3 * in.latency_max_us());
}

void to_ros2(const AttitudeMessage& attitude, const CalibratedSample& sample, std::int64_t stamp_ns,
             const std::string& frame_id, sensor_msgs::msg::Imu& out) {
  set_header(out.header(), stamp_ns, frame_id);
  const auto& q = attitude.q_world_body_xyzw;
  out.orientation().x(q[0]);
  out.orientation().y(q[1]);
  out.orientation().z(q[2]);
  out.orientation().w(q[3]);
  out.orientation_covariance(attitude.orientation_covariance_rad2);
  if (attitude.status == AttitudeStatus::kInitializing) out.orientation_covariance()[0] = -1.0;
  out.angular_velocity(vector3(attitude.rate_radps));
  out.linear_acceleration(vector3(sample.acc_mps2));
  out.angular_velocity_covariance().fill(0.0);
  out.linear_acceleration_covariance().fill(0.0);
  if (!sample.holds(kGyr)) out.angular_velocity_covariance()[0] = -1.0;
  if (!sample.holds(kAcc)) out.linear_acceleration_covariance()[0] = -1.0;
}

void to_ros2(const CalibratedSample& sample, std::int64_t stamp_ns, const std::string& frame_id,
             sensor_msgs::msg::MagneticField& out) {
  set_header(out.header(), stamp_ns, frame_id);
  out.magnetic_field(vector3(sample.mag_uT, kTeslaPerMicrotesla));
  out.magnetic_field_covariance().fill(0.0);
}

void to_ros2(const DiagnosticsMessage& in, std::int64_t stamp_ns, diagnostic_msgs::msg::DiagnosticArray& out) {
  constexpr std::uint8_t kOkLevel = 0, kWarn = 1, kStaleLevel = 3;
  set_header(out.header(), stamp_ns, "");
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level(in.status == AttitudeStatus::kOk ? kOkLevel : in.status == AttitudeStatus::kStale ? kStaleLevel : kWarn);
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
  add("latency_us_p50", percentile(0.5));
  add("latency_us_p99", percentile(0.99));
  add("latency_us_max", fmt::format("{:.1f}", us(in.latency_max_ns)));
  add("temperature_c", fmt::format("{:.2f}", in.temp_degC));
  add("last_refusal_reason", in.last_refusal);
  out.status().assign(1, status);
}

}  // namespace stillpoint::io

#include "io/dds_convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stillpoint::io {
namespace {

constexpr std::size_t kIdBound = 127, kTextBound = 255, kMissingBound = 1023;  // of idl/stillpoint.idl
constexpr std::int64_t kFurthest_ns = 4'600'000'000'000'000'000;  // the difference of any two times still fits
bool is_time(std::int64_t t_ns) { return t_ns > -kFurthest_ns && t_ns < kFurthest_ns; }
static_assert(std::tuple_size_v<LatencyCounts> == 640, "the length in idl/stillpoint.idl");

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

bool from_wire(const msg::SensorCalibration& in, TriadCalibration& out, std::string& reason) {
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
  return in.status() <= static_cast<std::uint8_t>(CalibrationStatus::kReplaced);
}

template <class Health>
auto in_wire_order(Health& h) {
  return std::array{&h.acc, &h.gyr, &h.mag, &h.temp};
}

void to_wire(const SensorsHealth& in, std::array<msg::SensorHealth, 4>& out) {
  const auto sensors = in_wire_order(in);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].state(static_cast<std::uint8_t>(sensors[i]->state));
    out[i].fault(static_cast<std::uint8_t>(sensors[i]->fault));
    out[i].since_ns(sensors[i]->since_ns);
    out[i].evidence(sensors[i]->evidence);
  }
}

void from_wire(const std::array<msg::SensorHealth, 4>& in, SensorsHealth& out) {
  const auto sensors = in_wire_order(out);
  for (std::size_t i = 0; i < in.size(); ++i)
    *sensors[i] = {static_cast<Health>(in[i].state()), static_cast<Fault>(in[i].fault()), in[i].since_ns(),
                   in[i].evidence()};
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
  const auto sensors = in_wire_order(in.health);
  for (std::size_t i = 0; i < sensors.size(); ++i) out.health()[i] = static_cast<std::uint8_t>(sensors[i]->state);
}

bool from_wire(const msg::Attitude& in, AttitudeMessage& out) noexcept {
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
  const auto sensors = in_wire_order(out.health);
  for (std::size_t i = 0; i < sensors.size(); ++i) sensors[i]->state = static_cast<Health>(in.health()[i]);
  return is_time(in.t_ns()) && is_time(in.t_arrival_ns()) && is_time(in.t_publish_ns());
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

bool from_wire(const msg::RawImu& in, RawSample& out) noexcept {
  out.t_ns = in.t_ns();
  out.sequence = in.sample_number();
  out.acc_mps2 = in.acc_mps2();
  out.gyr_radps = in.gyr_radps();
  out.mag_uT = in.mag_uT();
  out.temp_degC = in.temperature_degC();
  out.has = static_cast<std::uint8_t>(in.has() & (kAcc | kGyr | kMag | kTemp));
  return is_time(in.t_ns()) && is_time(in.t_arrival_ns());
}

void to_wire(const CalibrationMessage& in, msg::CalibrationState& out) {
  out.t_ns(in.snapshot.t_ns);
  out.version(in.snapshot.version);
  out.sensor_id(in.sensor_id.substr(0, kIdBound));
  to_wire(msg::SENSOR_ACC, in.snapshot.acc, in.reasons[0], out.sensors()[0]);
  to_wire(msg::SENSOR_GYR, in.snapshot.gyr, in.reasons[1], out.sensors()[1]);
  to_wire(msg::SENSOR_MAG, in.snapshot.mag, in.reasons[2], out.sensors()[2]);
}

bool from_wire(const msg::CalibrationState& in, CalibrationMessage& out) {
  out.snapshot.t_ns = in.t_ns();
  out.snapshot.version = in.version();
  out.sensor_id = in.sensor_id();
  return from_wire(in.sensors()[0], out.snapshot.acc, out.reasons[0]) &&
         from_wire(in.sensors()[1], out.snapshot.gyr, out.reasons[1]) &&
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
  out.not_finite(in.not_finite);
  out.write_failures(in.write_failures);
  out.datagrams_malformed(in.datagrams_malformed);
  out.datagrams_off_host(in.datagrams_off_host);
  out.datagrams_flooded(in.datagrams_flooded);
  out.latency_p50_us(us(latency_percentile_ns(in.latency_counts, 0.50)));
  out.latency_p90_us(us(latency_percentile_ns(in.latency_counts, 0.90)));
  out.latency_p99_us(us(latency_percentile_ns(in.latency_counts, 0.99)));
  out.latency_p999_us(us(latency_percentile_ns(in.latency_counts, 0.999)));
  out.latency_max_us(us(in.latency_max_ns));
  out.temperature_degC(in.temp_degC);
  out.status(static_cast<std::uint8_t>(in.status));
  out.heading_reference(static_cast<std::uint8_t>(in.heading_reference));
  to_wire(in.health, out.health());
  out.sensor_id(in.sensor_id.substr(0, kIdBound));
  out.source(in.source.substr(0, kTextBound));
  out.message(in.message.substr(0, kTextBound));
  out.missing(in.missing.substr(0, kMissingBound));
  out.last_refusal(in.last_refusal.substr(0, kTextBound));
  out.latency_counts(in.latency_counts);
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
  out.not_finite = in.not_finite();
  out.write_failures = in.write_failures();
  out.datagrams_malformed = in.datagrams_malformed();
  out.datagrams_off_host = in.datagrams_off_host();
  out.datagrams_flooded = in.datagrams_flooded();
  out.temp_degC = in.temperature_degC();
  out.status = static_cast<AttitudeStatus>(in.status());
  out.heading_reference = static_cast<HeadingReference>(in.heading_reference());
  from_wire(in.health(), out.health);
  out.sensor_id = in.sensor_id();
  out.source = in.source();
  out.message = in.message();
  out.missing = in.missing();
  out.last_refusal = in.last_refusal();
  out.latency_counts = in.latency_counts();
  // A stranger may send any number; what is not one becomes the least.
  out.latency_max_ns = static_cast<std::int64_t>(1e3 * std::clamp(std::fmax(in.latency_max_us(), 0.0), 0.0, 1e15));
}

}  // namespace stillpoint::io

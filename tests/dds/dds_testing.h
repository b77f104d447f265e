/// What the DDS tests share: a domain of their own, messages in which every field differs, comparison bit for bit,
/// bounded waiting.
#pragma once
#include <unistd.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <thread>
#include <vector>

#include "core/attitude_message.h"
#include "io/dds_domain.h"
#include "io/dds_params.h"

namespace stillpoint::test {

/// In a domain of its own, so that parallel runs do not meet.
inline io::DdsParams test_params(const char* transport = "udp") {
  io::DdsParams params;
  params.domain = io::own_domain();
  params.transport = transport;
  return params;
}

/// Of a discovery server of the test's own.
inline std::uint16_t server_port() { return static_cast<std::uint16_t>(12000 + io::own_domain()); }

/// Polls until the condition holds, at most ten seconds.
template <class Condition>
bool eventually(const Condition& condition) {
  for (int i = 0; i < 2000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

/// Every field has a value that no other field has, NaN, infinity and a denormal among them.
inline AttitudeMessage attitude_message(std::uint64_t k) {
  AttitudeMessage m;
  double next = 0.1 + static_cast<double>(k);
  const auto fill = [&next](auto& values) {
    for (double& x : values) x = next = 1.0 / (next + 3.0);
  };
  m.t_ns = 1'000'000'007LL + static_cast<std::int64_t>(k) * 1'000'000;
  m.t_arrival_ns = 5;
  m.sequence = k;
  m.calibration_version = k * 3;
  m.gaps = k + 11;
  m.dropped = k + 12;
  fill(m.q_world_body_xyzw);
  fill(m.rate_radps);
  fill(m.gyro_bias_radps);
  fill(m.orientation_covariance_rad2);
  fill(m.sigma_rpy_rad);
  m.orientation_covariance_rad2[3] = std::numeric_limits<double>::infinity();
  m.orientation_covariance_rad2[4] = std::numeric_limits<double>::denorm_min();
  m.rate_radps[1] = -0.0;
  if (k % 2 == 0) m.temp_degC = 21.5;  // else NaN
  m.at_rest = k % 2 == 1;
  m.status = AttitudeStatus::kDegraded;
  m.heading_reference = HeadingReference::kTrue;
  m.health.mag.state = Health::kFaulty;
  m.health.acc.state = Health::kSuspect;
  return m;
}

inline RawSample raw_sample(std::uint64_t k) {
  const double x = static_cast<double>(k);
  RawSample s{.t_ns = 1'000'000'000LL + static_cast<std::int64_t>(k) * 1'000'000,
              .sequence = k,
              .acc_mps2 = {0.1 + x / 3, -9.80665, 1e-17},
              .gyr_radps = {x / 7, -x / 7, 0.3},
              .mag_uT = {},
              .temp_degC = 20.0 + 1e-6 * x,
              .has = kAcc | kGyr | kTemp};
  if (k % 5 != 0) return s;  // the magnetometer is slower
  s.mag_uT = {20.1, x / 11, -43.7};
  s.has = static_cast<std::uint8_t>(s.has | kMag);
  return s;
}

inline CalibrationMessage calibration_message() {
  CalibrationMessage m;
  m.snapshot.version = 7;
  m.snapshot.t_ns = 123;
  double next = 0.5;
  for (TriadCalibration* c : {&m.snapshot.acc, &m.snapshot.gyr, &m.snapshot.mag}) {
    for (auto* values : {&c->bias, &c->bias_per_K, &c->bias_per_K2})
      for (double& x : *values) x = next += 0.25;
    for (auto* values : {&c->matrix, &c->bias_covariance})
      for (double& x : *values) x = next += 0.25;
    c->temp_min_degC = next += 0.25;
    c->temp_max_degC = next += 0.25;
    c->norm_sd = next += 0.25;
    c->windows = static_cast<std::uint32_t>(next * 4);
  }
  m.snapshot.acc.status = CalibrationStatus::kOk;
  m.snapshot.gyr.status = CalibrationStatus::kNotObservable;
  m.sensor_id = "bmi270:42";
  m.reasons = {"", "the rotations seen lie around one axis", "no magnetometer"};
  return m;
}

inline DiagnosticsMessage diagnostics_message() {
  DiagnosticsMessage m;
  m.uptime_s = 12.5;
  m.rate_hz = 199.5;
  m.samples = 2500;
  m.status = AttitudeStatus::kOk;
  m.message = "running";
  m.source = "stream /dev/ttyUSB0";
  m.missing =
      "what is learnt is not kept: the folder of the state cannot be made; it is tried again every five seconds";
  m.health.gyr = {Health::kFaulty, Fault::kStuck, 12'000'000'000, 3.5};
  m.health.temp = {Health::kAbsent, Fault::kAbsent, 0, 0.0};
  m.not_finite = 3;
  m.datagrams_malformed = 4;
  m.datagrams_off_host = 5;
  m.datagrams_flooded = 6;
  m.last_refusal = "turning at 0.6 deg/s";
  m.latency_counts[40] = 90;
  m.latency_counts[400] = 10;
  m.latency_max_ns = 1'500'000;
  return m;
}

/// All that the pipeline computes, as bits: equal if and only if the attitudes are the same to the last bit. The two
/// times of the machine's clock are left out.
inline std::vector<std::uint64_t> bits(const AttitudeMessage& m) {
  std::vector<std::uint64_t> out{static_cast<std::uint64_t>(m.t_ns), m.sequence, m.calibration_version, m.gaps,
                                 m.dropped};
  const auto add = [&out](const auto& values) {
    for (const double x : values) out.push_back(std::bit_cast<std::uint64_t>(x));
  };
  add(m.q_world_body_xyzw);
  add(m.rate_radps);
  add(m.gyro_bias_radps);
  add(m.orientation_covariance_rad2);
  add(m.sigma_rpy_rad);
  add(std::array{m.temp_degC});
  out.push_back(m.at_rest ? 1 : 0);
  out.push_back(static_cast<std::uint64_t>(m.status));
  out.push_back(static_cast<std::uint64_t>(m.heading_reference));
  for (const auto* sensor : {&m.health.acc, &m.health.gyr, &m.health.mag, &m.health.temp})
    out.push_back(static_cast<std::uint64_t>(sensor->state));
  return out;
}

}  // namespace stillpoint::test

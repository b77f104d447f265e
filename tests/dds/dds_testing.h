/// What the DDS tests share: a domain of their own, messages in which every field differs, comparison bit for bit,
/// bounded waiting.
#pragma once
#include <unistd.h>

#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <thread>
#include <vector>

#include "core/attitude_message.h"
#include "io/dds_params.h"

namespace stillpoint::test {

/// Every test program run has its own domain, so that parallel runs do not meet. Up to 100: higher ones share ports
/// with the kernel's ephemeral range.
inline io::DdsParams test_params(const char* transport = "udp") {
  io::DdsParams params;
  params.domain = 1 + static_cast<int>(getpid() % 100);
  params.transport = transport;
  return params;
}

/// Sends messages between two participants of this process through the transport, as between two processes.
inline void use_the_transport_inside_the_process() {
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
}

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
  return out;
}

}  // namespace stillpoint::test

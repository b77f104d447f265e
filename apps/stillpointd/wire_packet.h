/// Messages as bytes between two processes of one program: one compiler laid them out for both sides.
#pragma once
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "core/attitude_message.h"
#include "io/dds_neighbours.h"
#include "io/dds_params.h"

namespace stillpoint::app {

enum class PacketKind : std::uint32_t { kSettings, kRaw, kRos2, kCalibration, kDiagnostics, kAcknowledge };

struct RawPacket {
  RawSample sample;
  std::int64_t t_arrival_ns = 0;
};
struct Ros2Packet {
  AttitudeMessage attitude;
  CalibratedSample calibrated;
  RawSample raw;
  ReadingCovariances covariances;
};

/// The fields of what holds texts, in the order of the bytes.
template <class M>
auto packed(M& m) {
  using Plain = std::remove_const_t<M>;
  if constexpr (std::is_same_v<Plain, CalibrationMessage>) {
    return std::tie(m.snapshot, m.sensor_id, m.reasons[0], m.reasons[1], m.reasons[2]);
  } else if constexpr (std::is_same_v<Plain, DiagnosticsMessage>) {
    return std::tie(m.t_publish_ns, m.uptime_s, m.rate_hz, m.expected_rate_hz, m.samples, m.gaps, m.longest_gap_s,
                    m.dropped, m.clipped, m.refused, m.not_finite, m.write_failures, m.datagrams_malformed,
                    m.datagrams_off_host, m.datagrams_flooded, m.temp_degC, m.status, m.heading_reference, m.health,
                    m.sensor_id, m.source, m.message, m.missing, m.last_refusal, m.latency_counts, m.latency_max_ns);
  } else if constexpr (std::is_same_v<Plain, io::Neighbours>) {
    return std::tie(m.publishers, m.of_other_type, m.refused, m.asked_for, m.unreachable, m.unreachable_name);
  } else if constexpr (std::is_same_v<Plain, io::SecurityParams>) {
    return std::tie(m.folder, m.identity_ca, m.certificate, m.private_key, m.governance, m.permissions_ca,
                    m.permissions);
  } else {
    static_assert(std::is_same_v<Plain, io::DdsParams>);
    return std::tie(m.domain, m.transport, m.interface, m.attitude_topic, m.calibration_topic, m.diagnostics_topic,
                    m.raw_topic, m.ros2, m.ros2_readings, m.ros2_namespace, m.frame_id, m.name_space,
                    m.discovery_server, m.security);
  }
}

class PacketWriter {
 public:
  explicit PacketWriter(PacketKind kind) { put(kind); }
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      put(value.size());
      append(value.data(), value.size());
    } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
      put(value.size());
      for (const auto& one : value) put(one);
    } else if constexpr (std::is_trivially_copyable_v<T>) {
      append(&value, sizeof value);
    } else {
      std::apply([this](const auto&... field) { (put(field), ...); }, packed(value));
    }
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_)); }

 private:
  void append(const void* from, std::size_t n) { bytes_.append(static_cast<const char*>(from), n); }
  std::string bytes_;
};

/// Reads what a PacketWriter wrote; what is missing at the end stays as it was.
class PacketReader {
 public:
  explicit PacketReader(std::span<const std::byte> bytes) : bytes_(bytes) { get(kind_); }
  [[nodiscard]] PacketKind kind() const { return kind_; }
  template <class T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      std::size_t size = 0;
      get(size);
      if (size > bytes_.size()) return;
      value.assign(reinterpret_cast<const char*>(bytes_.data()), size);
      bytes_ = bytes_.subspan(size);
    } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
      std::size_t count = 0;
      get(count);
      value.clear();
      for (std::size_t k = 0; k < count && !bytes_.empty(); ++k) get(value.emplace_back());
    } else if constexpr (std::is_trivially_copyable_v<T>) {
      if (sizeof value > bytes_.size()) return;
      std::memcpy(static_cast<void*>(&value), bytes_.data(), sizeof value);
      bytes_ = bytes_.subspan(sizeof value);
    } else {
      std::apply([this](auto&... field) { (get(field), ...); }, packed(value));
    }
  }
  template <class T>
  [[nodiscard]] T get() {
    T value{};
    get(value);
    return value;
  }

 private:
  std::span<const std::byte> bytes_;
  PacketKind kind_ = PacketKind::kSettings;
};

}  // namespace stillpoint::app

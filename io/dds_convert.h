/// Core structs to wire messages and back, field by field. The stillpoint messages lose nothing either way, but for the
/// attitude's health: of it only the states travel with each attitude.
#pragma once
#include <stillpoint_idl/ros2.h>
#include <stillpoint_idl/stillpoint.h>

#include <cstdint>
#include <string>

#include "core/attitude_message.h"

namespace stillpoint::io {

/// Allocation-free.
void to_wire(const AttitudeMessage& in, msg::Attitude& out) noexcept;
/// False, here and below: of a time that no clock has (beyond 146 years either way).
bool from_wire(const msg::Attitude& in, AttitudeMessage& out) noexcept;
void to_wire(const RawSample& in, std::int64_t t_arrival_ns, msg::RawImu& out) noexcept;
bool from_wire(const msg::RawImu& in, RawSample& out) noexcept;

/// Texts longer than the IDL's bound are cut.
void to_wire(const CalibrationMessage& in, msg::CalibrationState& out);
/// False: of a status that this version does not know.
bool from_wire(const msg::CalibrationState& in, CalibrationMessage& out);
void to_wire(const DiagnosticsMessage& in, msg::Diagnostics& out);
void from_wire(const msg::Diagnostics& in, DiagnosticsMessage& out);

/// When and of which frame a ROS 2 message is. `stamp_ns` is CLOCK_REALTIME of the measurement.
struct Ros2Header {
  std::int64_t stamp_ns = 0;
  const std::string& frame_id;
};

/// [us] as messages state latencies.
[[nodiscard]] constexpr double us(std::int64_t ns) noexcept { return 1e-3 * static_cast<double>(ns); }

/// sensor_msgs/Imu after REP-145: orientation of the body in ENU, specific force, covariance row-major; covariance[0] =
/// -1 where the field is absent, zeros where its error is not known.
void to_ros2(const AttitudeMessage& attitude, const CalibratedSample& sample, const ReadingCovariances& covariances,
             const Ros2Header& header, sensor_msgs::msg::Imu& out);
/// The same without an orientation: imu/data_raw, bias and matrix not applied.
void to_ros2_raw(const RawSample& in_body_axes, const ReadingCovariances& covariances, const Ros2Header& header,
                 sensor_msgs::msg::Imu& out);
/// sensor_msgs/MagneticField, in tesla.
void to_ros2(const CalibratedSample& sample, const ReadingCovariances& covariances, const Ros2Header& header,
             sensor_msgs::msg::MagneticField& out);
/// sensor_msgs/Temperature; its variance is not known.
void to_ros2(double temp_degC, const Ros2Header& header, sensor_msgs::msg::Temperature& out);
/// One status of rt/diagnostics, after REP-107.
void to_ros2(const DiagnosticsMessage& in, std::int64_t stamp_ns, diagnostic_msgs::msg::DiagnosticArray& out);

}  // namespace stillpoint::io

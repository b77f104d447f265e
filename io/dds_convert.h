/// Core structs to wire messages and back, field by field. The stillpoint messages lose nothing either way.
#pragma once
#include <stillpoint_idl/ros2.h>
#include <stillpoint_idl/stillpoint.h>

#include <cstdint>
#include <string>

#include "core/attitude_message.h"

namespace stillpoint::io {

/// Allocation-free.
void to_wire(const AttitudeMessage& in, msg::Attitude& out) noexcept;
void from_wire(const msg::Attitude& in, AttitudeMessage& out) noexcept;
void to_wire(const RawSample& in, std::int64_t t_arrival_ns, msg::RawImu& out) noexcept;
void from_wire(const msg::RawImu& in, RawSample& out) noexcept;

/// Texts longer than the IDL's bound are cut.
void to_wire(const CalibrationMessage& in, msg::CalibrationState& out);
void from_wire(const msg::CalibrationState& in, CalibrationMessage& out);
void to_wire(const DiagnosticsMessage& in, msg::Diagnostics& out);
void from_wire(const msg::Diagnostics& in, DiagnosticsMessage& out);

/// sensor_msgs/Imu after REP-145: orientation of the body in ENU, specific force, covariance row-major; covariance[0] =
/// -1 where the field is absent, zeros where its error is not known. `stamp_ns` is CLOCK_REALTIME of the measurement.
void to_ros2(const AttitudeMessage& attitude, const CalibratedSample& sample, std::int64_t stamp_ns,
             const std::string& frame_id, sensor_msgs::msg::Imu& out);
/// sensor_msgs/MagneticField, in tesla.
void to_ros2(const CalibratedSample& sample, std::int64_t stamp_ns, const std::string& frame_id,
             sensor_msgs::msg::MagneticField& out);
/// One status of rt/diagnostics, after REP-107.
void to_ros2(const DiagnosticsMessage& in, std::int64_t stamp_ns, diagnostic_msgs::msg::DiagnosticArray& out);

}  // namespace stillpoint::io

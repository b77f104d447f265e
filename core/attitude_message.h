/// What the daemon says about each sample, and about itself: plain structs that the pipeline fills and io/ puts on the
/// wire. The wire form is idl/stillpoint.idl, field by field the same.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>

#include "core/attitude_status.h"
#include "core/calibration.h"
#include "core/health.h"
#include "core/latency_histogram.h"
#include "core/types.h"

namespace stillpoint {

/// One attitude. Trivially copyable, so it crosses rings and cells.
struct AttitudeMessage {
  std::int64_t t_ns = 0;          ///< time of the sample, the source's clock
  std::int64_t t_arrival_ns = 0;  ///< CLOCK_MONOTONIC when the sensor thread had the sample; 0 offline
  std::int64_t t_publish_ns = 0;  ///< CLOCK_MONOTONIC just before the write; set by the publisher
  std::uint64_t sequence = 0;     ///< counts the source's samples
  std::uint64_t calibration_version = 0;
  std::uint64_t gaps = 0;     ///< gaps in the source's times so far
  std::uint64_t dropped = 0;  ///< samples lost inside the daemon so far
  std::array<double, 4> q_world_body_xyzw{0, 0, 0, 1};
  Array3 rate_radps{};                   ///< body frame, calibrated, bias removed
  Array3 gyro_bias_radps{};              ///< removed by the filter beyond the calibration
  Array9 orientation_covariance_rad2{};  ///< row-major, about the fixed world axes
  Array3 sigma_rpy_rad{};
  double temp_degC = std::numeric_limits<double>::quiet_NaN();
  bool at_rest = false;
  AttitudeStatus status = AttitudeStatus::kInitializing;
  HeadingReference heading_reference = HeadingReference::kRelative;
  SensorsHealth health;
};

static_assert(std::is_trivially_copyable_v<AttitudeMessage>);

/// Variances of the readings beside an attitude, row-major, in the axes of the message; all zeros: not known.
struct ReadingCovariances {
  Array9 acc_mps2_2{}, gyr_radps_2{}, mag_uT_2{};
};

/// The calibration in use, with the reasons in words. Slow thread only.
struct CalibrationMessage {
  CalibrationSnapshot snapshot;
  std::string sensor_id;
  std::array<std::string, 3> reasons;  ///< acc, gyr, mag; empty when status is kOk
};

/// The daemon's health. Slow thread only. `latency` is of arrival to just before the write.
struct DiagnosticsMessage {
  std::int64_t t_publish_ns = 0;  ///< set by the publisher
  double uptime_s = 0.0;
  double rate_hz = 0.0;
  double expected_rate_hz = 0.0;  ///< 0: not known yet
  std::uint64_t samples = 0;
  std::uint64_t gaps = 0;
  double longest_gap_s = 0.0;
  std::uint64_t dropped = 0;
  std::uint64_t clipped = 0;
  std::uint64_t refused = 0;     ///< samples that were not used at all: empty, repeated, out of order or too late
  std::uint64_t not_finite = 0;  ///< readings taken out of their samples
  std::uint64_t write_failures = 0;
  std::uint64_t datagrams_malformed = 0, datagrams_off_host = 0, datagrams_flooded = 0;  ///< kept from DDS
  double temp_degC = std::numeric_limits<double>::quiet_NaN();
  AttitudeStatus status = AttitudeStatus::kInitializing;
  HeadingReference heading_reference = HeadingReference::kRelative;
  SensorsHealth health;
  std::string sensor_id;
  std::string message;       ///< one sentence for a person
  std::string source;        ///< where the samples come from, in words
  std::string missing;       ///< what the daemon does without at the moment, in sentences; empty: nothing
  std::string last_refusal;  ///< why the last candidate for a rest window was refused
  LatencyCounts latency_counts{};
  std::int64_t latency_max_ns = 0;
};

}  // namespace stillpoint

/// What the attitude filter says about one sample.
#pragma once
#include <cstdint>
#include <type_traits>

#include "core/attitude_status.h"
#include "core/types.h"

namespace stillpoint::fusion {

/// World frame ENU, body frame x forward, y left, z up (in_ned() converts). Always a unit quaternion, always finite.
struct AttitudeEstimate {
  std::int64_t t_ns = 0;            ///< time of the sample
  Array4 q_world_body{1, 0, 0, 0};  ///< w, x, y, z; rotates body vectors into the world
  Array9 covariance_world_rad2{};   ///< of the rotation error about the fixed world axes (REP-103), row-major
  Array9 unexplained_rad2{};        ///< of that, what is no weight against another estimate: (A28), (A30), (A34)
  double sigma_roll_rad = 0.0;      ///< standard deviation about the horizontal axis of the heading
  double sigma_pitch_rad = 0.0;     ///< about the horizontal axis across the heading
  double sigma_yaw_rad = 0.0;       ///< about the vertical
  Array3 rate_body_radps{};         ///< angular rate without residual bias and residual matrix error
  Array3 gyro_bias_radps{};         ///< residual bias that remains after the calibration
  Array3 gyro_bias_sd_radps{};
  bool at_rest = false;
  bool gyro_offset_jumped = false;  ///< within the last 10 s a rest or a motion has shown another offset than known
  bool acc_offset_jumped = false;   ///< the same of the accelerometer, a motion
  bool denied = false;              ///< gravity and the field have both left their places in the world, at most 5 s ago
  HeadingReference heading = HeadingReference::kRelative;
  AttitudeStatus status = AttitudeStatus::kInitializing;  ///< never kStale: that is for the clock to say
  bool refused = false;  ///< not used at all: its time did not advance or none of its parts was usable
};

static_assert(std::is_trivially_copyable_v<AttitudeEstimate>);

/// Roll, pitch and yaw deviations from the attitude and its covariance: the horizontal axes are those of heading_of().
void set_sigmas(AttitudeEstimate& e) noexcept;

/// The same attitude with world NED and body x forward, y right, z down. The two frames of each pair are both turned
/// by a fixed rotation, so roll keeps its sign and pitch and yaw change theirs, as the conventions want.
[[nodiscard]] AttitudeEstimate in_ned(const AttitudeEstimate& enu) noexcept;

}  // namespace stillpoint::fusion

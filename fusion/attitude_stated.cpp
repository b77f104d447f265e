/// What the filter says of itself after a sample: the attitude, what its error may be, and what the heading stands on.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/so3.h"
#include "fusion/attitude_filter.h"
#include "fusion/attitude_storage.h"
#include "fusion/attitude_unknown.h"

namespace stillpoint::fusion {
namespace {

constexpr double kJumpTold_s = 10.0;       ///< long enough for whoever looks every few seconds
constexpr double kMagneticMemory_s = 2.0;  ///< a heading trusted this long ago still counts as magnetic
constexpr double kNoMagnetometer_s = 1.0;  ///< after this long without a reading there is none

}  // namespace

AttitudeEstimate AttitudeFilter::estimate(std::int64_t t_ns) const noexcept {
  AttitudeEstimate out;
  out.t_ns = t_ns;
  out.status = s_.status;
  out.at_rest = s_.at_rest;
  Mat3 cov = std::numbers::pi * std::numbers::pi * Mat3::Identity();
  if (s_.has_attitude) {
    out.q_world_body = s_.x.q_world_body;
    if (params_.prediction_s > 0.0) {
      out.q_world_body = array(quat(s_.x.q_world_body) * exp_quat(params_.prediction_s * vec(s_.rate_radps)));
    }
    out.unexplained_rad2 =
        array(Mat3(s_.error.pull().unexplained_rad2() + s_.motion_scale.leaning_rad2(0.5 * s_.error.tilt_rad2()) +
                   mat(s_.unlearnt_rad2)));
    cov = s_.error.P().block<3, 3>(kTheta, kTheta) + mat(s_.iron_rad2) + mat(s_.jumps.doubt_rad2()) +
          mat(out.unexplained_rad2) + mat(s_.sums.theta_rad2);
    cov.topLeftCorner<2, 2>().diagonal().array() += known_.acc_matrix_sd * known_.acc_matrix_sd + s_.carried_rad2;
    // (A24) A stamp may mean either end of its reading's interval: half a step.
    const Vec3 late = params_.stamp_sd * s_.rate_bridge.usual_step_s() * (mat(s_.R_world_body) * vec(s_.rate_radps));
    cov += late * late.transpose();
    if (heading_unknown()) cov(2, 2) += kUnknownHeading_rad2;
    // Who does not know which side is up does not know where the front points either.
    if (cov.topLeftCorner<2, 2>().trace() > 2.0 * kLostTilt_rad * kLostTilt_rad)
      cov(2, 2) = std::max(cov(2, 2), kUnknownHeading_rad2);
    for (int i = 0; i < 3; ++i) {
      out.gyro_bias_sd_radps[static_cast<std::size_t>(i)] =
          std::sqrt(std::max(0.0, s_.error.P()(kGyrBias + i, kGyrBias + i)));
    }
    out.rate_body_radps = s_.rate_radps;
    out.gyro_bias_radps = s_.x.gyr_bias_radps;
    out.denied = s_.denied_s > 0.0;
    out.gyro_offset_jumped = s_.since_gyr_jump_s < kJumpTold_s;
    out.acc_offset_jumped = s_.since_acc_jump_s < kJumpTold_s;
  }
  out.covariance_world_rad2 = array(cov);
  set_sigmas(out);
  if (s_.magnetic_s > 0.0) {
    const auto trusted = params_.declination_rad != 0.0 ? HeadingReference::kTrue : HeadingReference::kMagnetic;
    out.heading =
        s_.unmagnetic_s < kMagneticMemory_s && !s_.turn_witness.denied() ? trusted : HeadingReference::kDisturbed;
  }
  return out;
}

/// Between a magnetometer's first word and the first heading that can be trusted.
bool AttitudeFilter::heading_unknown() const noexcept {
  return params_.use_magnetometer && !s_.heading_given && s_.magnetic_s == 0.0 &&
         (s_.magnetometer_seen || s_.age_s < kNoMagnetometer_s);
}

}  // namespace stillpoint::fusion

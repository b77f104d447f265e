/// The beginnings of an attitude: from the first reading, and from the first after a pause.
#include <algorithm>
#include <cmath>

#include "core/directions.h"
#include "core/so3.h"
#include "core/units.h"
#include "fusion/attitude_filter.h"
#include "fusion/attitude_storage.h"
#include "fusion/attitude_unknown.h"

namespace stillpoint::fusion {
namespace {

constexpr double kMovingTilt_rad = 0.3;  ///< of one reading in the middle of a motion: 3 m/s^2 across gravity

}  // namespace

void AttitudeFilter::start_from(const Vec3& acc_mps2) noexcept {
  if (acc_mps2.norm() < kFalling_mps2) return;
  const Quat tilt = turn_between(acc_mps2, Vec3::UnitZ());
  const Quat turn_to_heading(Eigen::AngleAxisd(s_.start_heading_rad - heading_of(tilt), Vec3::UnitZ()));
  set_attitude(turn_to_heading * tilt);
  // What motion adds to gravity along the reading it adds across it too, where it tilts.
  s_.start_tilt_rad =
      kStartTilt_rad + std::min(1.0, std::abs(acc_mps2.norm() - kStandardGravity_mps2) / kStandardGravity_mps2);
  start_errors();
  s_.has_attitude = true;
  s_.status = AttitudeStatus::kOk;
}

void AttitudeFilter::start_errors() noexcept {
  ErrorVector sd = ErrorVector::Zero();
  sd.segment<2>(kTheta).setConstant(s_.start_tilt_rad);
  sd(kTheta + 2) = s_.heading_given ? s_.start_tilt_rad : 0.0;  // relative: counted from here
  sd.segment<3>(kVelocity).setConstant(params_.motion_speed_mps);
  sd.segment<3>(kGyrBias).setConstant(params_.gyr_bias_sd_radps);
  sd.segment<3>(kAccBias).setConstant(params_.acc_bias_sd_mps2);
  sd.segment<9>(kGyrMatrix).setConstant(params_.gyr_matrix_sd);
  sd(kDisturbance) = params_.heading_disturbance_rad;
  for (std::size_t i = 0; i < s_.gyr_unlearnt2.size(); ++i) {
    const double known2 = known_.gyr_matrix_sd[i] * known_.gyr_matrix_sd[i];
    s_.gyr_unlearnt2[i] = std::max(0.0, known2 - params_.gyr_matrix_sd * params_.gyr_matrix_sd);
  }
  s_.error.start(sd);
  s_.jumps.restart(s_.error);
}

/// (A32) While the start is under way the mean force is up, and nothing else is learnt.
bool AttitudeFilter::start_in_motion(double time_s) noexcept {
  if (s_.sums.motion.force == Array3{}) {  // a pause, or no accelerometer: what was known has to do
    if (s_.moving_start.under_way()) s_.moving_start.end();
    return false;
  }
  const Vec3 force = vec(s_.sums.motion.force) / time_s;
  s_.moving_start.observe(force, time_s);
  if (!s_.moving_start.under_way()) return false;
  const bool came_to_rest = !s_.sums.moved;
  if (came_to_rest) s_.moving_start.end();
  const Vec3 up = came_to_rest ? force : s_.moving_start.force_mps2();
  if (up.norm() > kFalling_mps2) turn_world(turn_between(up, Vec3::UnitZ()));
  s_.start_tilt_rad = came_to_rest ? kStartTilt_rad : s_.moving_start.tilt_sd_rad();
  const Array4 q = s_.x.q_world_body;
  s_.x = Nominal{};
  s_.x.q_world_body = q;
  start_errors();
  const double speed2 = params_.motion_speed_mps * params_.motion_speed_mps + s_.moving_start.speed2_m2ps2();
  for (int i = 0; i < 3; ++i) s_.error.forget(kVelocity + i, speed2);
  s_.motion_scale = {};
  s_.error.pull() = {};
  s_.field = FieldReference{};
  s_.magnetic_s = 0.0;
  s_.sums = Sums{};
  return true;
}

/// The values stay, their deviations are those of the start.
void AttitudeFilter::forget_sensors() noexcept {
  for (int i = 0; i < 3; ++i) {
    s_.error.forget(kGyrBias + i, params_.gyr_bias_sd_radps * params_.gyr_bias_sd_radps);
    s_.error.forget(kAccBias + i, params_.acc_bias_sd_mps2 * params_.acc_bias_sd_mps2);
  }
  for (int i = 0; i < 9; ++i) s_.error.forget(kGyrMatrix + i, params_.gyr_matrix_sd * params_.gyr_matrix_sd);
}

void AttitudeFilter::bridge(const CalibratedSample& sample, bool gyr, bool acc, double dt_s) noexcept {
  // What was gathered before the pause is one step, the pause another.
  if (s_.sums.motion.time_s > 0.0) covariance_step();
  const Vec3 before = vec(s_.rate_radps);
  Mat3 unknown = Mat3::Identity() * unknown_turn2(dt_s);  // rad^2, in the world
  if (gyr) {
    const auto R = mat(s_.R_world_body);
    unknown = R * s_.rate_bridge.bridge_rad2(dt_s) * R.transpose();
    const Eigen::Map<const Mat3> M(s_.x.gyr_matrix.data());
    const Vec3 raw = vec(sample.gyr_radps);
    vec(s_.rate_radps) = raw - M * raw - vec(s_.x.gyr_bias_radps);
  }
  const Vec3 turned = 0.5 * dt_s * (before + vec(s_.rate_radps));
  s_.moving_start.interrupt();
  s_.rate_bridge.interrupt();
  s_.iron_finder.interrupt();
  s_.turn_witness.interrupt();
  s_.witnesses.interrupt();
  unknown *= std::min(1.0, 3.0 * std::numbers::pi * std::numbers::pi / unknown.trace());
  mat(s_.sums.theta_rad2) += unknown;
  mat(s_.sums.motion.R) += mat(s_.R_world_body) * dt_s;
  // The motion goes on unseen: within its own bounds nothing is known of it any more.
  const double speed2 = params_.motion_speed_mps * params_.motion_speed_mps * s_.motion_scale.speed2();
  mat(s_.sums.velocity_m2ps2).diagonal().array() += std::min(unknown_speed2(dt_s), 2.0 * speed2);
  set_attitude(quat(s_.x.q_world_body) * exp_quat(turned));
  s_.sums.moved = true;
  const double tilt2 = s_.error.tilt_rad2() + unknown.topLeftCorner<2, 2>().trace();
  s_.regained &= tilt2 < kRegained_rad * kRegained_rad;
  if (!acc || tilt2 < kLostTilt_rad * kLostTilt_rad) return;
  const double heading2 = s_.error.P()(kTheta + 2, kTheta + 2) + unknown(2, 2) + tilt2;
  const Vec3 force = vec(sample.acc_mps2) - vec(s_.x.acc_bias_mps2);
  if (force.norm() < kFalling_mps2) return;
  const Quat down = turn_between(quat(s_.x.q_world_body) * force, Vec3::UnitZ());
  set_attitude(down * quat(s_.x.q_world_body));
  const double sd = kMovingTilt_rad + std::min(1.0, std::abs(force.norm() / kStandardGravity_mps2 - 1.0));
  for (int i = 0; i < 2; ++i) s_.error.forget(kTheta + i, sd * sd);
  s_.error.forget(kTheta + 2, std::min(heading2, kUnknownHeading_rad2));
  mat(s_.sums.theta_rad2).setZero();
}

}  // namespace stillpoint::fusion

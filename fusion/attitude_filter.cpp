#include "fusion/attitude_filter.h"

#include <algorithm>
#include <cmath>

#include "core/so3.h"
#include "core/units.h"
#include "fusion/attitude_storage.h"
#include "fusion/attitude_unknown.h"

namespace stillpoint::fusion {
namespace {

constexpr double kLargestRate_radps = 1e3;  ///< beyond these a reading is a fault, not a measurement
constexpr double kLargestForce_mps2 = 2e3;
constexpr double kLargestField_uT = 1e5;
constexpr double kBlow_s = 0.1;      ///< how long a clipped peak of the force lasts
constexpr double kStroke_s = 0.1;    ///< and how long one of the rate stays as it is
constexpr double kStuck_s = 1.0;     ///< noise changes a living reading long before
constexpr double kLies_s = 1000.0;   ///< of a rest longer than this the gyroscope knows less than the place
constexpr double kWanders_s = 10.0;  ///< in which an offset outside of its prior may become another one

bool usable(const CalibratedSample& s, SamplePart part, const Array3& reading, double limit) {
  return s.holds(part) && vec(reading).allFinite() && vec(reading).cwiseAbs().maxCoeff() < limit;
}

/// A vector of the body as it was before that turn, in axes of the body now.
Vec3 turned_back(const Vec3& v, const Array3& turn_rad) {
  return turn_rad == Array3{} ? v : Vec3(exp_quat(Vec3(-vec(turn_rad))) * v);
}

}  // namespace

AttitudeFilter::AttitudeFilter(const AttitudeFilterParams& params) noexcept
    : params_(params), known_{.acc_matrix_sd = params.acc_matrix_sd, .gyr_matrix_sd = {}} {
  known_.gyr_matrix_sd.fill(params.gyr_matrix_unlearnt_sd);
  reset();
}

void AttitudeFilter::reset(std::optional<double> heading_rad) noexcept {
  s_ = State{};
  s_.hard_iron.reset(params_.hard_iron);
  s_.heading_given = heading_rad.has_value() && std::isfinite(*heading_rad);
  if (s_.heading_given) s_.start_heading_rad = wrapped(*heading_rad);
}

void AttitudeFilter::use_noise(const WhiteNoise& noise) noexcept {
  params_.gyr_noise_radps_rtHz = noise.gyr_radps_rtHz;
  params_.acc_noise_mps2_rtHz = noise.acc_mps2_rtHz;
  params_.mag_noise_uT = noise.mag_uT;
}

void AttitudeFilter::turn_back() noexcept {
  for (Array3* x : {&s_.x.velocity_mps, &s_.x.gyr_bias_radps, &s_.rate_radps}) vec(*x) *= -1.0;
  s_.error.turn_back();
  s_.jumps.restart(s_.error);
  s_.motion_scale.turn_back();
  s_.rate_bridge.interrupt();
  s_.sums = Sums{};
  s_.error.pull() = {};
  s_.clock_started = false;
  params_.acc_lag_s *= -1.0;
}

AttitudeEstimate AttitudeFilter::step(const CalibratedSample& sample, bool at_rest) noexcept {
  const bool acc = usable(sample, kAcc, sample.acc_mps2, kLargestForce_mps2);
  const bool gyr = usable(sample, kGyr, sample.gyr_radps, kLargestRate_radps);
  const double dt_s = in_seconds(sample.t_ns - s_.t_ns);
  if (s_.clock_started && !(sample.t_ns > s_.t_ns)) {
    AttitudeEstimate last = estimate(s_.t_ns);
    last.refused = s_.has_attitude;
    return last;
  }
  s_.t_ns = sample.t_ns;
  const bool first = !s_.clock_started;
  s_.clock_started = true;
  if (sample.holds(kTemp) && std::isfinite(sample.temp_degC)) s_.temp_degC = sample.temp_degC;
  if (!s_.has_attitude && acc) start_from(vec(sample.acc_mps2));
  if (!s_.has_attitude || first) {
    gather_field(sample);
    return estimate(sample.t_ns);
  }
  s_.at_rest = at_rest;
  s_.age_s += dt_s;
  const bool pause = s_.rate_bridge.is_pause(dt_s);
  s_.rate_bridge.note_step(dt_s);
  judge(sample, acc, gyr, dt_s);
  if (pause) {
    bridge(sample, gyr, acc, dt_s);
    if (!s_.regained) s_.status = AttitudeStatus::kDegraded;
  } else {
    turn(sample, gyr, dt_s);
    accelerate(sample, acc, dt_s);
  }
  if (pause || !gyr) s_.since_pause_s = 0.0;  // either turns the body unseen
  gather_field(sample);
  s_.sums.motion.time_s += dt_s;
  s_.sums.moved |= !at_rest;
  if (pause || s_.sums.motion.time_s >= params_.update_period_s) covariance_step();
  return estimate(sample.t_ns);
}

void AttitudeFilter::set_attitude(const Quat& q_world_body) noexcept {
  s_.x.q_world_body = array(q_world_body);
  mat(s_.R_world_body) = quat(s_.x.q_world_body).toRotationMatrix();
}

/// And all that is known in its axes of the field and of the start. Velocity and position are turned by heading alone.
void AttitudeFilter::turn_world(const Quat& turn) noexcept {
  set_attitude(turn * quat(s_.x.q_world_body));
  const Mat3 R = turn.toRotationMatrix();
  s_.iron_finder.turn_world(R);
  s_.turn_witness.turn_world(R);
  s_.moving_start.turn_world(R);
}

void AttitudeFilter::judge(const CalibratedSample& sample, bool acc, bool gyr, double dt_s) noexcept {
  if (acc) s_.acc_repeats.note(sample.acc_mps2, dt_s);
  s_.gyr_heard = gyr;
  if (gyr) s_.gyr_repeats.note(sample.gyr_radps, dt_s);
  if (gyr) s_.gyr_line.note(sample.gyr_radps, dt_s);
  const bool acc_stuck = s_.acc_repeats.time_s > kStuck_s;
  const bool gyr_stuck = s_.gyr_repeats.time_s > kStuck_s;
  // Both unchanged is a simulation without noise at rest; one unchanged beside a living one is stuck. Its reading may
  // still be true, so it serves on, with the noise of an absent one.
  const bool drawn = gyr && s_.gyr_line.drawn();  // its own time is unknown
  if (drawn || (gyr_stuck && acc && !acc_stuck)) {
    mat(s_.sums.theta_rad2).diagonal().array() += unknown_turn2(dt_s);
  }
  if (acc_stuck && gyr && !gyr_stuck) mat(s_.sums.velocity_m2ps2).diagonal().array() += unknown_speed2(dt_s);
  const bool acc_there = acc || (!sample.holds(kAcc) && (sample.absent & kAcc) == 0);
  const bool whole = acc_there && gyr && acc_stuck == gyr_stuck && !drawn && sample.clipped == 0 && s_.regained &&
                     !s_.moving_start.under_way();
  s_.status = whole ? AttitudeStatus::kOk : AttitudeStatus::kDegraded;
}

void AttitudeFilter::turn(const CalibratedSample& sample, bool usable_reading, double dt_s) noexcept {
  const double rate2 = vec(s_.rate_radps).squaredNorm();
  double noise2 = (params_.gyr_noise_radps_rtHz * params_.gyr_noise_radps_rtHz +
                   params_.gyr_rate_noise_rtHz * params_.gyr_rate_noise_rtHz * rate2) *
                  dt_s;
  const Vec3 raw = usable_reading ? Vec3(vec(sample.gyr_radps)) : Vec3::Zero();
  const auto R = mat(s_.R_world_body);
  if (usable_reading) {
    const Eigen::Map<const Mat3> M(s_.x.gyr_matrix.data());
    vec(s_.rate_radps) = raw - M * raw - vec(s_.x.gyr_bias_radps);
    mat(s_.sums.motion.R) += R * dt_s;
    for (std::size_t j = 0; j < 3; ++j) mat(s_.sums.motion.R_rate[j]) += R * (raw(static_cast<int>(j)) * dt_s);
  } else {  // what the body does in the meantime says nothing of the gyroscope's offset
    noise2 += unknown_turn2(dt_s);
  }
  const Vec3 rate = vec(s_.rate_radps);
  vec(s_.sums.rate_radps_s) += rate * dt_s;
  mat(s_.sums.theta_rad2).diagonal().array() += noise2;
  if (usable_reading && (sample.clipped & kGyr) != 0) {
    // (A9) At the limit the true rate is larger by an unknown part of the reading, and by what it has gone on since.
    int axis = 0;
    const double peak = raw.cwiseAbs().maxCoeff(&axis);
    if (s_.clipped_s == 0.0) s_.clip_slope_radps2 = std::max(0.0, (peak - s_.unclipped_radps) / dt_s);
    s_.clipped_s += dt_s;
    const Vec3 about = R.col(axis) * (0.3 * peak + s_.clip_slope_radps2 * s_.clipped_s);
    mat(s_.sums.theta_rad2) += about * about.transpose() * (kStroke_s * dt_s);
  } else {
    s_.clipped_s = 0.0;
    s_.unclipped_radps = raw.cwiseAbs().maxCoeff();
  }
  set_attitude(quat(s_.x.q_world_body) * exp_quat(rate * dt_s));
}

void AttitudeFilter::accelerate(const CalibratedSample& sample, bool usable_reading, double dt_s) noexcept {
  // One that only speaks more rarely than the gyroscope is held; in the world, where the body's turning is no change.
  const bool held = !usable_reading && !sample.holds(kAcc) && (sample.absent & kAcc) == 0 && s_.acc_heard;
  if (!usable_reading && !held) {
    mat(s_.sums.velocity_m2ps2).diagonal().array() += unknown_speed2(dt_s);
    return;
  }
  if (usable_reading) {
    s_.acc_heard = true;
    Array3 turn_rad = sample.acc_turn_rad;
    if (params_.acc_lag_s != 0.0) vec(turn_rad) += params_.acc_lag_s * vec(s_.rate_radps);
    vec(s_.force_world_mps2) =
        mat(s_.R_world_body) * turned_back(vec(sample.acc_mps2) - vec(s_.x.acc_bias_mps2), turn_rad);
  }
  const Vec3 force = vec(s_.force_world_mps2);
  vec(s_.sums.motion.force) += force * dt_s;
  const Vec3 before = vec(s_.x.velocity_mps);
  vec(s_.x.velocity_mps) += (force - Vec3(0, 0, kStandardGravity_mps2)) * dt_s;
  vec(s_.x.position_m) += 0.5 * dt_s * (before + vec(s_.x.velocity_mps));
  auto noise = mat(s_.sums.velocity_m2ps2);
  noise.diagonal().array() += params_.acc_noise_mps2_rtHz * params_.acc_noise_mps2_rtHz * dt_s;
  if ((sample.clipped & kAcc) == 0) return;
  // (A9) What the rail cut off has the direction of the axis at it: half as much again, for as long as a blow lasts.
  int axis = 0;
  const double peak = vec(sample.acc_mps2).cwiseAbs().maxCoeff(&axis);
  const Vec3 along = mat(s_.R_world_body).col(axis) * (0.5 * peak);
  noise += along * along.transpose() * (kBlow_s * dt_s);
}

void AttitudeFilter::gather_field(const CalibratedSample& sample) noexcept {
  if (!params_.use_magnetometer || !usable(sample, kMag, sample.mag_uT, kLargestField_uT)) return;
  // A magnetometer slower than the gyroscope is often held: an old reading turned by a new attitude is wrong.
  if (s_.magnetometer_seen && sample.mag_uT == s_.last_field_uT) return;
  s_.magnetometer_seen = true;
  s_.last_field_uT = sample.mag_uT;
  if ((sample.clipped & kMag) != 0 || !s_.has_attitude) return;
  Mat3 R = mat(s_.R_world_body);
  if (sample.mag_turn_rad != Array3{}) R = R * exp_so3(Vec3(-vec(sample.mag_turn_rad)));
  vec(s_.sums.field_uT) += R * vec(sample.mag_uT);
  mat(s_.sums.field_R) += R;
  ++s_.sums.fields;
}

void AttitudeFilter::covariance_step() noexcept {
  const double time_s = s_.sums.motion.time_s;
  if (start_in_motion(time_s)) return;
  ProcessNoise noise;
  noise.theta_rad2 = s_.sums.theta_rad2;
  noise.velocity_m2ps2 = s_.sums.velocity_m2ps2;
  noise.gyr_bias_walk = params_.gyr_bias_walk_radps_rtHz;
  noise.acc_bias_walk = params_.acc_bias_walk_mps2_rtHz;
  noise.disturbance_rad = params_.heading_disturbance_rad;
  noise.disturbance_time_s = params_.heading_disturbance_time_s;
  s_.error.propagate(s_.sums.motion, noise);
  s_.error.pull().pass(vec(s_.x.gyr_bias_radps), mat(s_.R_world_body), time_s);
  s_.x.disturbance_rad *= std::exp(-time_s / params_.heading_disturbance_time_s);
  hear_witnesses(time_s);
  weigh_surprise(time_s);
  measure_motion(time_s);
  s_.since_rest_s += time_s;
  s_.since_gyr_jump_s += time_s;
  s_.since_acc_jump_s += time_s;
  s_.lies_s = s_.sums.moved ? 0.0 : std::min(s_.lies_s + time_s, kLies_s);
  if (s_.sums.moved) {
    s_.denied_rest = {};
    end_insisting();
  } else {
    measure_rest(time_s);
  }
  if (s_.sums.moved) s_.unmagnetic_s += time_s;  // at rest nothing turns, so the last heading serves
  if (s_.sums.fields > 0) measure_field(time_s);
  s_.rate_bridge.observe(vec(s_.sums.rate_radps_s) / time_s, time_s);
  judge_jumps(time_s);
  inject();
  const double tilt2 = s_.error.tilt_rad2();
  s_.regained &= s_.gyr_heard || tilt2 < kLostTilt_rad * kLostTilt_rad;
  s_.regained |= tilt2 < kRegained_rad * kRegained_rad;
  state_ride();
  mat(s_.unlearnt_rad2) = s_.error.unlearnt_rad2(s_.gyr_unlearnt2);
  mat(s_.iron_rad2) = s_.error.iron_rad2(s_.hard_iron.left_uT2(params_.hard_iron));
  const Eigen::RowVector3d turned = s_.error.by_iron().row(kTheta + 2).head<3>();  // the heading, per uT of iron
  mat(s_.iron_rad2)(2, 2) += turned * s_.hard_iron.unseen_uT2(params_.hard_iron) * turned.transpose();
  for (int i = 0; i < 3; ++i) {
    // (A23) Outside of its prior it is no constant, but what this motion makes of a lever arm or a bent scale.
    const double offset = vec(s_.x.acc_bias_mps2)(i);
    if (std::abs(offset) > 3.0 * params_.acc_bias_sd_mps2)
      s_.error.add_variance(kAccBias + i, offset * offset * time_s / kWanders_s);
  }
  s_.sums = Sums{};
}

void AttitudeFilter::inject() noexcept {
  const ErrorVector d = s_.error.take_mean();
  if (!d.allFinite() || !s_.error.P().diagonal().allFinite()) {
    start_errors();  // overflow: keep the attitude, forget what was known of its error
    return;
  }
  turn_world(exp_quat(d.segment<3>(kTheta)));
  const Mat3 heading = exp_so3(Vec3(0.0, 0.0, d(kTheta + 2)));
  vec(s_.x.velocity_mps) = heading * vec(s_.x.velocity_mps) + d.segment<3>(kVelocity);
  vec(s_.x.position_m) = heading * vec(s_.x.position_m) + d.segment<3>(kPosition);
  s_.x.disturbance_rad += d(kDisturbance);
  if (s_.denied_s > 0.0 && s_.learning_anew_s <= 0.0) return;
  vec(s_.x.gyr_bias_radps) += d.segment<3>(kGyrBias);
  vec(s_.x.acc_bias_mps2) += d.segment<3>(kAccBias);
  Eigen::Map<Eigen::Matrix<double, 9, 1>>(s_.x.gyr_matrix.data()) += d.segment<9>(kGyrMatrix);
}

}  // namespace stillpoint::fusion

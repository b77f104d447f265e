#include "fusion/attitude_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::fusion {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLongestStep_s = 0.5;      ///< over a longer gap the last rate says nothing
constexpr double kUnknownRate_radps = 2.0;  ///< rate of a body whose gyroscope is absent: moved by hand
constexpr double kUnknownRate_time_s = 0.2;
constexpr double kUnknownForce_mps2 = 5.0;  ///< acceleration while the accelerometer is absent
constexpr double kLargestRate_radps = 1e3;  ///< beyond these a reading is a fault, not a measurement
constexpr double kLargestForce_mps2 = 1e4;
constexpr double kLargestField_uT = 1e5;
constexpr double kStartTilt_rad = 0.1;     ///< the first reading may hold 1 m/s^2 of motion
constexpr double kMagneticMemory_s = 2.0;  ///< a heading trusted this long ago still counts as magnetic

Quat quat(const Array4& q) { return Quat(q[0], q[1], q[2], q[3]); }

Array4 array(const Quat& q) {
  const Quat n = q.normalized();
  const double sign = n.w() < 0 ? -1.0 : 1.0;
  return {sign * n.w(), sign * n.x(), sign * n.y(), sign * n.z()};
}

bool usable(const CalibratedSample& s, SamplePart part, const Array3& reading, double limit) {
  return s.holds(part) && vec(reading).allFinite() && vec(reading).cwiseAbs().maxCoeff() < limit;
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

/// Heading of q: the angle of its turn about the vertical, counter-clockwise from east. Defined at every tilt but
/// upside down.
double heading_of(const Quat& q) { return wrapped(2.0 * std::atan2(q.z(), q.w())); }

}  // namespace

AttitudeFilter::AttitudeFilter(const AttitudeFilterParams& params) noexcept : params_(params) { reset(); }

void AttitudeFilter::reset(std::optional<double> heading_rad) noexcept {
  s_ = State{};
  s_.heading_given = heading_rad.has_value() && std::isfinite(*heading_rad);
  if (s_.heading_given) s_.start_heading_rad = wrapped(*heading_rad);
}

AttitudeEstimate AttitudeFilter::step(const CalibratedSample& sample, bool at_rest) noexcept {
  const bool acc = usable(sample, kAcc, sample.acc_mps2, kLargestForce_mps2);
  const bool gyr = usable(sample, kGyr, sample.gyr_radps, kLargestRate_radps);
  const double dt_s = kSecondsPerNs * static_cast<double>(sample.t_ns - s_.t_ns);
  if (s_.clock_started && !(sample.t_ns > s_.t_ns)) {
    s_.status = s_.has_attitude ? AttitudeStatus::kRefused : AttitudeStatus::kWaiting;
    return estimate(s_.t_ns);
  }
  s_.t_ns = sample.t_ns;
  const bool first = !s_.clock_started;
  s_.clock_started = true;
  if (sample.holds(kTemp) && std::isfinite(sample.temp_degC)) s_.temp_degC = sample.temp_degC;
  if (!s_.has_attitude) {
    if (acc) start_from(vec(sample.acc_mps2));
    if (!s_.has_attitude || first) {
      gather_field(sample);
      return estimate(sample.t_ns);
    }
  }
  s_.at_rest = at_rest;
  s_.status =
      acc && gyr && sample.clipped == 0 && dt_s < kLongestStep_s ? AttitudeStatus::kOk : AttitudeStatus::kDegraded;
  turn(sample, gyr, dt_s);
  accelerate(sample, acc, dt_s);
  gather_field(sample);
  s_.sums.motion.time_s += dt_s;
  s_.sums.moved |= !at_rest;
  if (s_.sums.motion.time_s >= params_.update_period_s) covariance_step();
  return estimate(sample.t_ns);
}

void AttitudeFilter::start_from(const Vec3& acc_mps2) noexcept {
  if (acc_mps2.norm() < 0.1 * kStandardGravity_mps2) return;  // falling: there is no down
  const Quat tilt = Quat::FromTwoVectors(acc_mps2, Vec3::UnitZ());
  const Quat turn_to_heading(Eigen::AngleAxisd(s_.start_heading_rad - heading_of(tilt), Vec3::UnitZ()));
  s_.x.q_world_body = array(turn_to_heading * tilt);
  ErrorVector sd = ErrorVector::Zero();
  sd.segment<2>(kTheta).setConstant(kStartTilt_rad);
  sd(kTheta + 2) = s_.heading_given ? kStartTilt_rad : 0.0;
  sd.segment<3>(kVelocity).setConstant(params_.motion_speed_mps);
  sd.segment<3>(kGyrBias).setConstant(params_.gyr_bias_sd_radps);
  sd.segment<3>(kAccBias).setConstant(params_.acc_bias_sd_mps2);
  sd.segment<9>(kGyrMatrix).setConstant(params_.gyr_matrix_sd);
  sd(kDisturbance) = params_.heading_disturbance_rad;
  s_.error.start(sd);
  s_.has_attitude = true;
  s_.status = AttitudeStatus::kOk;
}

void AttitudeFilter::turn(const CalibratedSample& sample, bool usable_reading, double dt_s) noexcept {
  Quat q = quat(s_.x.q_world_body);
  const double unknown2 = kUnknownRate_radps * kUnknownRate_radps * 2.0 * kUnknownRate_time_s * dt_s;
  double noise2 = params_.gyr_noise_radps_rtHz * params_.gyr_noise_radps_rtHz * dt_s;
  Vec3 raw = Vec3::Zero();
  if (usable_reading) {
    raw = vec(sample.gyr_radps);
    const Eigen::Map<const Mat3> M(s_.x.gyr_matrix.data());
    vec(s_.rate_radps) = raw - M * raw - vec(s_.x.gyr_bias_radps);
  } else {
    noise2 += unknown2;
  }
  if (dt_s > kLongestStep_s) {
    vec(s_.rate_radps) *= usable_reading ? 1.0 : 0.0;
    noise2 += unknown2;
  }
  const double turned_s = std::min(dt_s, kLongestStep_s);
  const Vec3 rate = vec(s_.rate_radps);
  const Mat3 R = q.toRotationMatrix();
  vec(s_.sums.rate_radps_s) += rate * turned_s;
  mat(s_.sums.motion.R) += R * dt_s;
  for (std::size_t j = 0; j < 3; ++j) {
    mat(s_.sums.motion.R_rate[j]) += R * (raw(static_cast<int>(j)) * turned_s);
  }
  mat(s_.sums.theta_rad2) += noise2 * Mat3::Identity();
  if (usable_reading && (sample.clipped & kGyr) != 0) {
    // (A9) At the limit the true rate is larger by an unknown part of the reading, for as long as a stroke lasts.
    int axis = 0;
    const double peak = raw.cwiseAbs().maxCoeff(&axis);
    const Vec3 about = R.col(axis) * (0.3 * peak);
    mat(s_.sums.theta_rad2) += about * about.transpose() * (0.1 * dt_s);
  }
  s_.x.q_world_body = array(q * exp_quat(rate * turned_s));
}

void AttitudeFilter::accelerate(const CalibratedSample& sample, bool usable_reading, double dt_s) noexcept {
  const double turned_s = std::min(dt_s, kLongestStep_s);
  if (!usable_reading || dt_s > kLongestStep_s) {
    s_.sums.velocity_m2ps2 += kUnknownForce_mps2 * kUnknownForce_mps2 * turned_s * turned_s;
    return;
  }
  const Vec3 force = quat(s_.x.q_world_body) * Vec3(vec(sample.acc_mps2) - vec(s_.x.acc_bias_mps2));
  vec(s_.sums.motion.force) += force * dt_s;
  const Vec3 before = vec(s_.x.velocity_mps);
  vec(s_.x.velocity_mps) += (force - Vec3(0, 0, kStandardGravity_mps2)) * dt_s;
  vec(s_.x.position_m) += 0.5 * dt_s * (before + vec(s_.x.velocity_mps));
  const double clipped_mps2 = (sample.clipped & kAcc) != 0 ? 0.3 * vec(sample.acc_mps2).norm() : 0.0;
  s_.sums.velocity_m2ps2 +=
      (params_.acc_noise_mps2_rtHz * params_.acc_noise_mps2_rtHz + 0.1 * clipped_mps2 * clipped_mps2) * dt_s;
  s_.sums.accelerated = true;
}

void AttitudeFilter::gather_field(const CalibratedSample& sample) noexcept {
  if (!params_.use_magnetometer || !usable(sample, kMag, sample.mag_uT, kLargestField_uT)) return;
  // A magnetometer slower than the gyroscope is often held: an old reading turned by a new attitude is wrong.
  if (s_.magnetometer_seen && sample.mag_uT == s_.last_field_uT) return;
  s_.magnetometer_seen = true;
  s_.last_field_uT = sample.mag_uT;
  if ((sample.clipped & kMag) != 0 || !s_.has_attitude) return;
  vec(s_.sums.field_uT) += quat(s_.x.q_world_body) * Vec3(vec(sample.mag_uT));
  ++s_.sums.fields;
}

void AttitudeFilter::covariance_step() noexcept {
  const double time_s = s_.sums.motion.time_s;
  ProcessNoise noise;
  noise.theta_rad2 = s_.sums.theta_rad2;
  noise.velocity_m2ps2 = s_.sums.velocity_m2ps2;
  noise.gyr_bias_walk = params_.gyr_bias_walk_radps_rtHz;
  noise.acc_bias_walk = params_.acc_bias_walk_mps2_rtHz;
  noise.disturbance_rad = params_.heading_disturbance_rad;
  noise.disturbance_time_s = params_.heading_disturbance_time_s;
  s_.error.propagate(s_.sums.motion, noise);
  s_.x.disturbance_rad *= std::exp(-time_s / params_.heading_disturbance_time_s);
  if (s_.sums.accelerated) measure_motion(time_s);
  if (!s_.sums.moved) measure_rest(time_s);
  s_.unmagnetic_s += time_s;
  if (s_.sums.fields > 0) measure_heading(time_s);
  inject();
  s_.sums = Sums{};
}

void AttitudeFilter::measure_motion(double time_s) noexcept {
  // (A8) A quantity that wanders about zero with deviation s and correlation time t has the power density 2 s^2 t.
  const double per_time = 2.0 * params_.motion_time_s / time_s;
  const double speed2 = params_.motion_speed_mps * params_.motion_speed_mps * per_time;
  const double radius2 = params_.motion_radius_m * params_.motion_radius_m * per_time;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    s_.error.update(kVelocity + i, -s_.x.velocity_mps[at], speed2);
    s_.error.update(kPosition + i, -s_.x.position_m[at], radius2);
  }
}

void AttitudeFilter::measure_rest(double time_s) noexcept {
  const double speed2 = params_.rest_speed_mps * params_.rest_speed_mps;
  const double rate2 = params_.rest_rate_radps * params_.rest_rate_radps +
                       params_.gyr_noise_radps_rtHz * params_.gyr_noise_radps_rtHz / time_s;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    s_.error.update(kVelocity + i, -s_.x.velocity_mps[at], speed2);
    s_.error.update(kGyrBias + i, s_.sums.rate_radps_s[at] / time_s, rate2);
  }
}

void AttitudeFilter::measure_heading(double time_s) noexcept {
  const Vec3 field = vec(s_.sums.field_uT) / s_.sums.fields;
  const double horizontal = std::hypot(field.x(), field.y());
  const FieldVerdict verdict = s_.field.observe(params_.field_reference, horizontal, field.z(), time_s, s_.sums.moved);
  if (!verdict.trusted && !verdict.accepted) return;
  // Magnetic north lies at pi/2 - declination from east; the field seems turned from it by minus the heading error.
  const double error = wrapped(0.5 * kPi - params_.declination_rad - std::atan2(field.y(), field.x()));
  if (s_.magnetic_s == 0.0 && !s_.heading_given) {
    s_.x.q_world_body = array(Quat(Eigen::AngleAxisd(error, Vec3::UnitZ())) * quat(s_.x.q_world_body));
    const double tilt = kStartTilt_rad * field.z() / horizontal;
    s_.error.forget(kTheta + 2, params_.heading_disturbance_rad * params_.heading_disturbance_rad +
                                    params_.heading_noise_rad * params_.heading_noise_rad + tilt * tilt);
    vec(s_.x.velocity_mps).setZero();
    vec(s_.x.position_m).setZero();
    s_.magnetic_s = time_s;
    s_.unmagnetic_s = 0.0;
    return;
  }
  if (verdict.accepted) {  // the present heading is kept: all of the deviation is the place's
    s_.x.disturbance_rad = error;
    s_.error.forget(kDisturbance,
                    s_.error.P()(kTheta + 2, kTheta + 2) + params_.heading_noise_rad * params_.heading_noise_rad);
    return;
  }
  ErrorVector h = ErrorVector::Zero();
  h(kTheta + 2) = 1.0;
  h(kDisturbance) = 1.0;
  const double variance = params_.heading_noise_rad * params_.heading_noise_rad + verdict.heading_variance_rad2;
  s_.error.update(h, wrapped(error - s_.x.disturbance_rad), variance);
  s_.magnetic_s += time_s;
  s_.unmagnetic_s = 0.0;
}

void AttitudeFilter::inject() noexcept {
  const ErrorVector d = s_.error.take_mean();
  if (!d.allFinite()) return;
  s_.x.q_world_body = array(exp_quat(d.segment<3>(kTheta)) * quat(s_.x.q_world_body));
  vec(s_.x.velocity_mps) += d.segment<3>(kVelocity);
  vec(s_.x.position_m) += d.segment<3>(kPosition);
  vec(s_.x.gyr_bias_radps) += d.segment<3>(kGyrBias);
  vec(s_.x.acc_bias_mps2) += d.segment<3>(kAccBias);
  Eigen::Map<Eigen::Matrix<double, 9, 1>>(s_.x.gyr_matrix.data()) += d.segment<9>(kGyrMatrix);
  s_.x.disturbance_rad += d(kDisturbance);
}

AttitudeEstimate AttitudeFilter::estimate(std::int64_t t_ns) const noexcept {
  AttitudeEstimate out;
  out.t_ns = t_ns;
  out.status = s_.status;
  out.at_rest = s_.at_rest;
  Mat3 cov = kPi * kPi * Mat3::Identity();
  if (s_.has_attitude) {
    const Quat q = quat(s_.x.q_world_body);
    out.q_world_body = s_.x.q_world_body;
    if (params_.prediction_s > 0.0) {
      out.q_world_body = array(q * exp_quat(params_.prediction_s * vec(s_.rate_radps)));
    }
    cov = s_.error.P().block<3, 3>(kTheta, kTheta) + mat(s_.sums.theta_rad2);
    for (int i = 0; i < 3; ++i) {
      out.gyro_bias_sd_radps[static_cast<std::size_t>(i)] =
          std::sqrt(std::max(0.0, s_.error.P()(kGyrBias + i, kGyrBias + i)));
    }
    out.rate_body_radps = s_.rate_radps;
    out.gyro_bias_radps = s_.x.gyr_bias_radps;
  }
  out.covariance_world_rad2 = stillpoint::array(cov);
  const double heading = heading_of(quat(out.q_world_body));
  const Vec3 ahead(std::cos(heading), std::sin(heading), 0.0);
  const Vec3 across(-ahead.y(), ahead.x(), 0.0);
  out.sigma_roll_rad = std::sqrt(std::max(0.0, ahead.dot(cov * ahead)));
  out.sigma_pitch_rad = std::sqrt(std::max(0.0, across.dot(cov * across)));
  out.sigma_yaw_rad = std::sqrt(std::max(0.0, cov(2, 2)));
  if (s_.magnetic_s > 0.0) {
    out.heading = s_.unmagnetic_s < kMagneticMemory_s ? HeadingReference::kMagnetic : HeadingReference::kDisturbed;
  }
  return out;
}

void AttitudeFilter::rebase(const CalibrationSnapshot& from, const CalibrationSnapshot& to) noexcept {
  // u' = H' (y - B') with y = H^-1 u + B, so u' = K u + c.
  const Mat3 H_new = mat(to.gyr.matrix);
  const Mat3 K_inverse = mat(from.gyr.matrix) * H_new.inverse();
  if (!K_inverse.allFinite()) return;
  // B and B' at their own reference: the difference of the slopes is new knowledge and passes through.
  const Vec3 c = H_new * (from.gyr.bias_at(s_.temp_degC) - to.gyr.bias_at(s_.temp_degC));
  Eigen::Map<Mat3> M(s_.x.gyr_matrix.data());
  const Mat3 gain = (Mat3::Identity() - M) * K_inverse;
  M = Mat3::Identity() - gain;
  vec(s_.x.gyr_bias_radps) += gain * c;
}

}  // namespace stillpoint::fusion

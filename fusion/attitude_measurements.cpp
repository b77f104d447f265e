/// What the attitude filter learns from motion, rest and the magnetic field: the measurements of AttitudeFilter.
#include <algorithm>
#include <cmath>

#include "fusion/attitude_filter.h"
#include "fusion/attitude_storage.h"

namespace stillpoint::fusion {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRestSurprise = 16.0;  ///< of a chi-square of three: one in a thousand at true rest
constexpr double kRestDoubt_s = 1.0;    ///< the rest detector has seen the motion by then
constexpr double kKnownTilt_rad = 0.05;

}  // namespace

void AttitudeFilter::measure_motion(double time_s) noexcept {
  const auto& P = s_.error.P();
  s_.motion_scale.observe({s_.x.velocity_mps[0], s_.x.velocity_mps[1]},
                          {P(kVelocity, kVelocity), P(kVelocity + 1, kVelocity + 1)}, params_.motion_speed_mps,
                          params_.motion_time_s, time_s);
  // (A8) A quantity that wanders about zero with deviation s and correlation time t has the power density 2 s^2 t.
  const double per_time = 2.0 * params_.motion_time_s / time_s;
  const double speed2 = params_.motion_speed_mps * params_.motion_speed_mps * per_time;
  const double radius2 = params_.motion_radius_m * params_.motion_radius_m * per_time;
  const double speed_scale = s_.motion_scale.speed2() * s_.motion_scale.time();
  const double radius_scale = s_.motion_scale.radius2() * s_.motion_scale.time();
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool level = i < 2;  // up and down nothing tilts
    s_.error.update(kVelocity + i, -s_.x.velocity_mps[at], level ? speed_scale * speed2 : speed2);
    s_.error.update(kPosition + i, -s_.x.position_m[at], level ? radius_scale * radius2 : radius2);
  }
}

void AttitudeFilter::measure_rest(double time_s) noexcept {
  const double speed2 = params_.rest_speed_mps * params_.rest_speed_mps;
  const double rate2 = params_.rest_rate_radps * params_.rest_rate_radps +
                       params_.gyr_noise_radps_rtHz * params_.gyr_noise_radps_rtHz / time_s;
  const Vec3 rate = vec(s_.sums.rate_radps_s) / time_s;
  // The rest detector looks back over a window; a motion that has just begun is seen here first.
  double surprise = 0.0;
  for (int i = 0; i < 2; ++i) surprise += rate(i) * rate(i) / (s_.error.P()(kGyrBias + i, kGyrBias + i) + rate2);
  s_.rest_doubt_s = surprise > kRestSurprise ? kRestDoubt_s : s_.rest_doubt_s - time_s;
  if (s_.rest_doubt_s > 0.0) return;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    s_.error.update(kVelocity + i, -s_.x.velocity_mps[at], speed2);
    s_.error.update(kGyrBias + i, rate(i), rate2);
  }
}

void AttitudeFilter::measure_field(double time_s) noexcept {
  const Mat3 R_mean = mat(s_.sums.field_R) / s_.sums.fields;
  const Vec3 seen = vec(s_.sums.field_uT) / s_.sums.fields;
  const Vec3 field = seen - R_mean * s_.hard_iron.body_uT(params_.hard_iron);
  const double horizontal2 = field.head<2>().squaredNorm();
  // A field turned by an unsure tilt has the wrong dip: until the tilt is known its reference is not learnt.
  const double tilt2 = s_.error.P()(kTheta, kTheta) + s_.error.P()(kTheta + 1, kTheta + 1);
  const bool leaning = tilt2 > kKnownTilt_rad * kKnownTilt_rad;
  if (leaning) s_.field = FieldReference{};
  const FieldVerdict verdict =
      s_.field.observe(params_.field_reference, std::sqrt(horizontal2), field.z(), time_s, s_.sums.moved);
  HeadingReading reading;
  // (A10) Magnetic north lies at pi/2 - declination from east; the field seems turned from it by minus the error.
  reading.error_rad = wrapped(0.5 * kPi - params_.declination_rad - std::atan2(field.y(), field.x()));
  // A tilt error leans the vertical field into the horizontal plane: the heading turns with the tilt about north.
  reading.lean = field.z() / horizontal2 * field.head<2>();
  reading.iron = (field.y() * R_mean.row(0) - field.x() * R_mean.row(1)) / horizontal2;
  reading.field_variance_rad2 = verdict.heading_variance_rad2;
  if (verdict.accepted) {  // the present heading is kept: all of the deviation is the place's
    s_.x.disturbance_rad = reading.error_rad;
    s_.error.forget(kDisturbance,
                    s_.error.P()(kTheta + 2, kTheta + 2) + params_.heading_noise_rad * params_.heading_noise_rad);
  } else if (verdict.trusted) {
    if (s_.magnetic_s == 0.0 && !s_.heading_given)
      start_heading(reading);
    else
      measure_heading(reading, time_s);
    s_.magnetic_s += time_s;
    s_.unmagnetic_s = 0.0;
  } else {
    s_.unmagnetic_s += s_.sums.moved ? 0.0 : time_s;  // in motion it has been counted already
  }
  if (leaning) return;
  const Vec3 iron = s_.hard_iron.body_uT(params_.hard_iron);
  s_.hard_iron.observe(params_.hard_iron, seen, R_mean, time_s);
  s_.error.change_iron(s_.hard_iron.body_uT(params_.hard_iron) - iron);
}

void AttitudeFilter::start_heading(const HeadingReading& reading) noexcept {
  const Quat turn_by(Eigen::AngleAxisd(reading.error_rad, Vec3::UnitZ()));
  set_attitude(turn_by * quat(s_.x.q_world_body));
  vec(s_.x.velocity_mps) = turn_by * Vec3(vec(s_.x.velocity_mps));
  vec(s_.x.position_m) = turn_by * Vec3(vec(s_.x.position_m));
  s_.error.forget(kTheta + 2, params_.heading_disturbance_rad * params_.heading_disturbance_rad +
                                  params_.heading_noise_rad * params_.heading_noise_rad);
  s_.error.by_iron().row(kTheta + 2).head<3>() = -reading.iron.transpose();
  s_.error.depend(kTheta + 2, turn_by.toRotationMatrix().topLeftCorner<2, 2>() * reading.lean);
}

void AttitudeFilter::measure_heading(const HeadingReading& reading, double time_s) noexcept {
  ErrorVector h = ErrorVector::Zero();
  h.segment<2>(kTheta) = -reading.lean;
  h(kTheta + 2) = 1.0;
  h(kDisturbance) = 1.0;
  const double instant = params_.heading_noise_rad * params_.heading_noise_rad + reading.field_variance_rad2;
  const double innovation = wrapped(reading.error_rad - s_.x.disturbance_rad);
  // (A13) Innovations of one sign that stay larger than they should mean a heading gone astray: believe it less.
  const double expected = s_.error.P()(kTheta + 2, kTheta + 2) + s_.error.P()(kDisturbance, kDisturbance) + instant;
  const double blend = std::min(1.0, time_s / params_.heading_doubt_time_s);
  s_.heading_stress += blend * (innovation * std::abs(innovation) / expected - s_.heading_stress);
  const double excess = std::abs(s_.heading_stress) - 1.0;
  if (excess > 0.0) s_.error.add_variance(kTheta + 2, params_.heading_doubt * blend * excess * expected);
  s_.error.update(h, innovation, instant * std::max(1.0, 2.0 * params_.heading_noise_time_s / time_s), reading.iron);
}

}  // namespace stillpoint::fusion

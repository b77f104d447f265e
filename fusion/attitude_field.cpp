/// What the attitude filter learns from the magnetic field.
#include <algorithm>
#include <cmath>

#include "fusion/attitude_filter.h"
#include "fusion/attitude_storage.h"

namespace stillpoint::fusion {
namespace {

constexpr double kKnownTilt_rad = 0.05;
constexpr double kLongUntrusted_s = 30.0;
constexpr double kAnotherHeading = 9.0;   ///< of a chi-square of one
constexpr double kLevel_rad = 0.14;       ///< beyond it a heading taken anew after a pause would be another one
constexpr double kLostHeading_rad = 0.6;  ///< the field is asked anew, without weighing it against what was

}  // namespace

void AttitudeFilter::measure_field(double time_s) noexcept {
  const Mat3 R_mean = mat(s_.sums.field_R) / s_.sums.fields;
  const Vec3 seen = vec(s_.sums.field_uT) / s_.sums.fields;
  const Vec3 field = seen - R_mean * s_.hard_iron.body_uT(params_.hard_iron);
  const double horizontal2 = field.head<2>().squaredNorm();
  // A field turned by an unsure tilt has the wrong dip: until the tilt is known its reference is not learnt.
  const double tilt2 = s_.error.tilt_rad2();
  const bool leaning = tilt2 > kKnownTilt_rad * kKnownTilt_rad;
  // After a pause the tilt may be far outside of where (A10) is a straight line. While the gyroscope holds the heading
  // it can wait for the tilt; without one the field is all there is.
  const bool waiting = !s_.regained && s_.gyr_heard && tilt2 > kLevel_rad * kLevel_rad;
  if (leaning) s_.field = FieldReference{};
  const FieldVerdict verdict =
      s_.field.observe(params_.field_reference, std::sqrt(horizontal2), field.z(), time_s, s_.sums.moved);
  s_.turn_witness.observe(field, R_mean, time_s);
  HeadingReading reading = HeadingReading::of(field, R_mean, params_.declination_rad);
  reading.field_variance_rad2 = verdict.heading_variance_rad2;
  reading.white_variance_rad2 = params_.mag_noise_uT * params_.mag_noise_uT / (s_.sums.fields * horizontal2);
  if (verdict.accepted) {  // the present heading is kept: all of the deviation is the place's
    s_.x.disturbance_rad = reading.error_rad;
    s_.error.forget(kDisturbance,
                    s_.error.P()(kTheta + 2, kTheta + 2) + params_.heading_noise_rad * params_.heading_noise_rad);
  } else if (verdict.trusted && !waiting) {
    const bool lost = s_.error.P()(kTheta + 2, kTheta + 2) > kLostHeading_rad * kLostHeading_rad;
    if ((s_.magnetic_s == 0.0 && !s_.heading_given) || lost)
      start_heading(reading);
    else
      measure_heading(reading, time_s);
    s_.magnetic_s += time_s;
    s_.unmagnetic_s = 0.0;
  } else {
    s_.unmagnetic_s += s_.sums.moved ? 0.0 : time_s;  // in motion it has been counted already
  }
  if (leaning) return;
  follow_iron(seen, R_mean, time_s);
}

void AttitudeFilter::follow_iron(const Vec3& seen, const Mat3& R_mean, double time_s) noexcept {
  const Vec3 iron = s_.hard_iron.body_uT(params_.hard_iron);
  s_.iron_finder.observe(seen, R_mean, time_s);
  if (s_.iron_finder.known() && (!s_.hard_iron.settled() || s_.unmagnetic_s > kLongUntrusted_s) &&
      s_.hard_iron.contradicted(params_.hard_iron, s_.iron_finder.body_uT(), s_.iron_finder.covariance_uT2())) {
    // Another iron than thought. It may have been there all the time, and every heading so far was taken from a wrong
    // field, or have come just now: the field without it tells.
    s_.hard_iron.begin_at(params_.hard_iron, s_.iron_finder.body_uT(), s_.iron_finder.covariance_uT2());
    s_.field = FieldReference{};
    s_.witnesses.forget_field();
    s_.error.by_iron().setZero();
    const double error =
        HeadingReading::error(seen - R_mean * s_.hard_iron.body_uT(params_.hard_iron), params_.declination_rad);
    const double expected =
        s_.error.P()(kTheta + 2, kTheta + 2) + params_.heading_noise_rad * params_.heading_noise_rad;
    if (error * error > kAnotherHeading * expected)
      s_.magnetic_s = 0.0;
    else
      s_.error.by_iron()(kTheta + 2, 3) = error;  // what the heading has of the other field
    return;
  }
  HardIronParams iron_params = params_.hard_iron;  // noise of its own as if it lasted like the place's: never too sure
  iron_params.noise_uT = std::hypot(iron_params.noise_uT, params_.mag_noise_uT / std::sqrt(s_.sums.fields));
  s_.hard_iron.observe(iron_params, seen, R_mean, time_s);
  s_.error.change_iron(s_.hard_iron.body_uT(params_.hard_iron) - iron);
}

void AttitudeFilter::start_heading(const HeadingReading& reading) noexcept {
  const Quat turn_by(Eigen::AngleAxisd(reading.error_rad, Vec3::UnitZ()));
  turn_world(turn_by);
  vec(s_.x.velocity_mps) = turn_by * Vec3(vec(s_.x.velocity_mps));
  vec(s_.x.position_m) = turn_by * Vec3(vec(s_.x.position_m));
  s_.error.turn_world(turn_by.toRotationMatrix());
  s_.witnesses.forget_field();
  s_.x.disturbance_rad = 0.0;
  s_.error.forget(kDisturbance, params_.heading_disturbance_rad * params_.heading_disturbance_rad);
  s_.error.forget(kTheta + 2, params_.heading_noise_rad * params_.heading_noise_rad + reading.field_variance_rad2 +
                                  reading.white_variance_rad2);
  s_.error.by_iron().row(kTheta + 2).head<3>() = -reading.iron.transpose();
  // (A10) read for theta_z: what the reading hangs on, the heading does from here on.
  ErrorVector weights = ErrorVector::Zero();
  weights.segment<2>(kTheta) = turn_by.toRotationMatrix().topLeftCorner<2, 2>() * reading.lean;
  weights(kDisturbance) = -1.0;
  s_.error.depend(kTheta + 2, weights);
  s_.heading_stress = 0.0;
  s_.error.pull().forget_heading();
}

void AttitudeFilter::measure_heading(const HeadingReading& reading, double time_s) noexcept {
  ErrorVector h = ErrorVector::Zero();
  h.segment<2>(kTheta) = -reading.lean;
  h(kTheta + 2) = 1.0;
  h(kDisturbance) = 1.0;
  const double instant = params_.heading_noise_rad * params_.heading_noise_rad + reading.field_variance_rad2;
  const double innovation = wrapped(reading.error_rad - s_.x.disturbance_rad);
  // (A13) Innovations of one sign that stay larger than they should mean a heading gone astray: believe it less.
  const double expected = s_.error.P()(kTheta + 2, kTheta + 2) + s_.error.P()(kDisturbance, kDisturbance) + instant +
                          reading.white_variance_rad2;
  const double blend = std::min(1.0, time_s / params_.heading_doubt_time_s);
  s_.heading_stress += blend * (innovation * std::abs(innovation) / expected - s_.heading_stress);
  const double excess = std::abs(s_.heading_stress) - 1.0;
  if (excess > 0.0) s_.error.add_variance(kTheta + 2, params_.heading_doubt * blend * excess * expected);
  // A body that lies stays where it is: however long, it is told of one deviation of the place, which this sums up to.
  const double usual_s = std::max(params_.heading_noise_time_s, time_s), lies = s_.lies_s / usual_s;
  const double lasts_s = usual_s * std::max(1.0, lies * lies);
  const double lasting = instant * std::max(1.0, 2.0 * lasts_s / time_s);
  s_.error.update(h, innovation, lasting + reading.white_variance_rad2, reading.iron,
                  taught_by_heading(reading, expected));
}

/// (A31) A body's iron goes round with the body: what it does to the heading looks like a scale of the gyroscope or an
/// offset of the accelerometer, which are learnt by the share that the iron has no part in. Where the field does not
/// even turn with the gyroscope it steers the heading alone. Where a vehicle accelerates gravity does not set the tilt
/// right again, which is then taught by that share too. `expected_rad2` is the innovation's variance.
ErrorVector AttitudeFilter::taught_by_heading(const HeadingReading& reading, double expected_rad2) const noexcept {
  ErrorVector taught = ErrorVector::Zero();
  taught(kTheta + 2) = taught(kDisturbance) = 1.0;
  if (s_.gyr_heard && s_.turn_witness.denied()) return taught;  // without a gyroscope the field is all there is
  const double of_iron_rad2 = reading.iron.dot(s_.hard_iron.left_uT2(params_.hard_iron) * reading.iron);
  taught.setOnes();
  taught.segment<3>(kAccBias).setConstant(expected_rad2 / (expected_rad2 + of_iron_rad2));
  taught.segment<9>(kGyrMatrix).setConstant(taught(kAccBias));
  if (s_.motion_scale.carried()) taught.segment<2>(kTheta).setConstant(taught(kAccBias));
  return taught;
}

}  // namespace stillpoint::fusion

/// What the attitude filter learns from motion and from rest. Of the field: attitude_field.cpp.
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "fusion/attitude_filter.h"
#include "fusion/attitude_storage.h"

namespace stillpoint::fusion {
namespace {

constexpr double kLeanTime_s = 3.0;     ///< within which an offset has made a lean that motion shows
constexpr double kPauseTells_s = 10.0;  ///< a lean within it is what the pause left
constexpr double kRestSurprise = 16.0;  ///< of a chi-square of three: one in a thousand at true rest
constexpr double kRideSurprise = 3.0;   ///< its mean
constexpr double kRestDoubt_s = 1.0;    ///< the rest detector has seen the motion by then
constexpr double kRestInsists_s = 3.0;  ///< the detector's own windows are shorter
constexpr double kRestLean = 6.0;       ///< mean of a chi-square of two: one in four hundred
constexpr double kDenied_s = 5.0;       ///< so long nothing is learnt of sensors that have been denied
constexpr double kLearnAnew_s = 10.0;   ///< after so long everything is, and for so long
constexpr double kDoubtIn_s = 1.0;
constexpr double kBeyondPrior = 3.0;        ///< standard deviations of an offset
constexpr double kKnownTurn_radps = 0.003;  ///< deviation of an offset about the vertical that a rest leaves
constexpr double kTaughtOfKnown = 0.5;      ///< share of (A37)
static_assert(kAccBias == kGyrBias + 3);

/// (A36) Not the heading, nor of offset and matrix of the gyroscope what turns about `up_body`.
void forget_turns(ErrorVector& gain, const Vec3& up_body) noexcept {
  gain(kTheta + 2) = 0.0;
  const auto forget_vertical = [&](auto rate) { rate -= up_body * up_body.dot(rate); };
  forget_vertical(gain.segment<3>(kGyrBias));
  for (int column = 0; column < 3; ++column) forget_vertical(gain.segment<3>(kGyrMatrix + 3 * column));
}

}  // namespace

/// (A8a) Hand or vehicle. What surprises of the velocity may be a lean, and an offset of the gyroscope may have made
/// it.
void AttitudeFilter::weigh_surprise(double time_s) noexcept {
  const auto& P = s_.error.P();
  const MotionScale::Seen seen{{s_.x.velocity_mps[0], s_.x.velocity_mps[1]},
                               {P(kVelocity, kVelocity), P(kVelocity + 1, kVelocity + 1)},
                               array(Vec3(vec(s_.sums.motion.force) / time_s)),
                               0.5 * s_.error.tilt_rad2(),
                               s_.error.gyr_bias_rad2ps2(),
                               s_.since_pause_s <= kPauseTells_s};
  const MotionScale::Lean lean =
      s_.motion_scale.observe(seen, {params_.motion_speed_mps, params_.motion_time_s}, time_s);
  const double leaning_rad2 = lean.rad2();
  if (lean.any_way) {
    for (int i = 0; i < 2; ++i) s_.error.add_variance(kTheta + i, leaning_rad2);
  } else {
    s_.error.add_lean(lean.share, Eigen::Vector2d(lean.tilt_rad.data()), Eigen::Vector2d(lean.velocity_mps.data()));
  }
  s_.since_pause_s += time_s;
  if (leaning_rad2 == 0.0 || s_.since_pause_s <= kPauseTells_s) return;
  // (A20) One about the vertical leans nothing. Nobody knows an offset less than at the start.
  const Vec3 up = mat(s_.R_world_body).row(2);
  const double known = 1.0 - seen.gyr_bias_rad2ps2 / (params_.gyr_bias_sd_radps * params_.gyr_bias_sd_radps);
  const double add = leaning_rad2 / (kLeanTime_s * kLeanTime_s) * std::max(0.0, known);
  s_.error.P().block<3, 3>(kGyrBias, kGyrBias) += add * (Mat3::Identity() - up * up.transpose());
}

void AttitudeFilter::measure_motion(double time_s) noexcept {
  // (A8) A quantity that wanders about zero with deviation s and correlation time t has the power density 2 s^2 t.
  const double per_time = 2.0 * params_.motion_time_s / time_s;
  const double speed2 = params_.motion_speed_mps * params_.motion_speed_mps * per_time;
  const double radius2 = params_.motion_radius_m * params_.motion_radius_m * per_time;
  const double speed_scale = s_.motion_scale.speed2() * s_.motion_scale.time();
  const double radius_scale = s_.motion_scale.radius2() * s_.motion_scale.time();
  const Vec3 up = mat(s_.R_world_body).row(2);
  const bool turns = turns_are_told(up), offset_known = s_.motion_scale.offset_known();
  const auto limit = [&](ErrorVector& gain) {
    if (!turns) forget_turns(gain, up);
    if (offset_known) gain.segment<6>(kGyrBias) *= kTaughtOfKnown;
  };
  const auto bounded = [&](int index, double value, double variance) {
    turns && !offset_known ? s_.error.update(index, -value, variance) : s_.error.update(index, -value, variance, limit);
  };
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool level = i < 2;  // up and down nothing tilts
    bounded(kVelocity + i, s_.x.velocity_mps[at], level ? speed_scale * speed2 : speed2);
    bounded(kPosition + i, s_.x.position_m[at], level ? radius_scale * radius2 : radius2);
  }
}

/// (A36) Who walks on keeps his speed in every turn, and (A8) would rather have turned the world under him. Only a
/// magnetometer, or an offset that a rest has shown, withstands that. In a vehicle the tilt leans on what turns tell.
bool AttitudeFilter::turns_are_told(const Vec3& up_body) const noexcept {
  const double offset2 = up_body.dot(s_.error.P().block<3, 3>(kGyrBias, kGyrBias) * up_body);
  return s_.magnetometer_seen || s_.motion_scale.carried() || offset2 < kKnownTurn_radps * kKnownTurn_radps;
}

void AttitudeFilter::state_ride() noexcept {
  const Vec3 up = mat(s_.R_world_body).row(2);
  const auto offset2 = s_.error.P().block<3, 3>(kGyrBias, kGyrBias);
  const double level2 = 0.5 * (offset2.trace() - up.dot(offset2 * up));
  s_.carried_rad2 = s_.jumps.still() * s_.motion_scale.carried_rad2(level2);
}

/// (A25) Both deny the attitude: it may be off by what gravity leans, and what was learnt of the sensors is void, as is
/// what they would teach now.
void AttitudeFilter::hear_witnesses(double time_s) noexcept {
  std::optional<Vec3> field;
  if (s_.sums.fields > 0)
    field = (vec(s_.sums.field_uT) - mat(s_.sums.field_R) * s_.hard_iron.body_uT(params_.hard_iron)) / s_.sums.fields;
  s_.witnesses.observe(vec(s_.sums.motion.force) / time_s, field, time_s);
  const double lean2 = s_.witnesses.denied_rad2();
  s_.denied_s = lean2 > 0.0 ? kDenied_s : s_.denied_s - time_s;
  s_.learning_anew_s -= time_s;
  if (s_.denied_s <= 0.0) {
    s_.denied_for_s = 0.0;
    return;
  }
  for (int i = 0; i < 3; ++i) s_.error.add_variance(kTheta + i, lean2 * time_s / kDoubtIn_s);
  if (s_.learning_anew_s > 0.0) return;
  forget_sensors();
  // What was learnt may itself be what they deny, and nothing corrects it meanwhile.
  s_.denied_for_s += time_s;
  if (s_.denied_for_s < kLearnAnew_s) return;
  s_.learning_anew_s = kLearnAnew_s;
  s_.denied_for_s = 0.0;
}

/// (A27) While the sensors are denied nothing is known that could have jumped; a pause leaves an error of its own.
void AttitudeFilter::judge_jumps(double time_s) noexcept {
  if (s_.denied_s > 0.0 || s_.since_pause_s < kPauseTells_s) {
    s_.jumps.restart(s_.error);
    return;
  }
  const OffsetJumps::Verdict verdict =
      s_.jumps.observe(s_.error, mat(s_.R_world_body).row(2), s_.motion_scale.carried(), time_s);
  if (verdict == OffsetJumps::Verdict::kGyroscope) s_.since_gyr_jump_s = 0.0;
  if (verdict == OffsetJumps::Verdict::kAccelerometer) s_.since_acc_jump_s = 0.0;
}

void AttitudeFilter::measure_rest(double time_s) noexcept {
  const double speed2 = params_.rest_speed_mps * params_.rest_speed_mps;
  const double rate2 = params_.rest_rate_radps * params_.rest_rate_radps +
                       params_.gyr_noise_radps_rtHz * params_.gyr_noise_radps_rtHz / time_s;
  const Vec3 rate = vec(s_.sums.rate_radps_s) / time_s;
  // The rest detector looks back over a window; a motion that has just begun is seen here first.
  // All three axes with their correlations, so that the mounting of the sensor does not matter.
  Mat3 expected = s_.error.P().block<3, 3>(kGyrBias, kGyrBias);
  expected.diagonal().array() += rate2;
  const double surprise = rate.dot(expected.llt().solve(rate));
  if (surprise > kRestSurprise) {
    s_.rest_doubt_s = kRestDoubt_s;
    s_.rest_denied_s += time_s;
    s_.denied_rest.note(vec(s_.sums.motion.force) / time_s, mat(s_.R_world_body) * rate, time_s);
    if (s_.rest_denied_s < kRestInsists_s && !s_.denied_rest.denies_gyroscope()) return;
    relearn_bias(rate);
    s_.insisted_radps = mat(s_.R_world_body).row(2).dot(rate);
    s_.insisted_s = s_.since_rest_s;
  }
  doubt_insistence(time_s);
  s_.rest_denied_s = s_.since_rest_s = 0.0;
  s_.denied_rest = {};
  s_.rest_doubt_s -= time_s;
  if (s_.rest_doubt_s > 0.0) return;
  doubt_motion(time_s, speed2);
  if (s_.motion_scale.carried()) doubt_offset();
  doubt_tilt(time_s);
  s_.motion_scale.rest();
  s_.error.pull().forget_tilt();
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    s_.error.update(kVelocity + i, -s_.x.velocity_mps[at], speed2);
    s_.error.update(kGyrBias + i, rate(i), rate2);
  }
  arrive();
}

/// (A39) Where it rests is where it is bounded to from here on. A ride ends far from where it began, and the bound of
/// that place would go on pulling tilt and offsets, against which a rest has nothing to say as they cancel.
void AttitudeFilter::arrive() noexcept {
  for (int i = 0; i < 3; ++i) {
    s_.x.position_m[static_cast<std::size_t>(i)] = -s_.error.mean()(kPosition + i);
    s_.error.forget(kPosition + i, params_.motion_radius_m * params_.motion_radius_m);
  }
}

/// A velocity that the rest contradicts was made by a tilt further off than its variance says. Its correlations with
/// everything else are as untrue: by them one update would throw all of it into whatever state is left, the
/// accelerometer's offset first. The rest is believed, and gravity shows the tilt anew.
void AttitudeFilter::doubt_motion(double time_s, double rest_speed2) noexcept {
  Mat3 expected = s_.error.P().block<3, 3>(kVelocity, kVelocity);
  expected.diagonal().array() += rest_speed2;
  const Vec3 velocity = vec(s_.x.velocity_mps) + s_.error.mean().segment<3>(kVelocity);
  // (A37) What has bounded a ride was untrue of it, and so is what its velocity goes with.
  const double surprise = s_.motion_scale.carried() ? kRideSurprise : kRestSurprise;
  if (velocity.dot(expected.llt().solve(velocity)) < surprise) return;
  (void)s_.error.take_mean();  // what the velocity has corrected in this period
  s_.x.velocity_mps = {};
  const Vec3 lean = vec(s_.sums.motion.force) / (time_s * kStandardGravity_mps2);
  for (int i = 0; i < 3; ++i) s_.error.forget(kVelocity + i, rest_speed2);
  forget_tilt(lean.head<2>().squaredNorm());
}

/// So much more is it off, and nothing that it went with tells of it any more.
void AttitudeFilter::forget_tilt(double lean2) noexcept {
  for (int i = 0; i < 2; ++i) s_.error.forget(kTheta + i, s_.error.P()(kTheta + i, kTheta + i) + lean2);
}

/// What a ride has taught of the accelerometer's offset beyond what such an offset can be was the vehicle's
/// acceleration, and the attitude leans by as much. The rest is to set the tilt right, not to confirm the offset.
void AttitudeFilter::doubt_offset() noexcept {
  const Vec3 offset = vec(s_.x.acc_bias_mps2);
  if (offset.cwiseAbs().maxCoeff() < kBeyondPrior * params_.acc_bias_sd_mps2) return;
  (void)s_.error.take_mean();
  s_.x.acc_bias_mps2 = {};
  for (int i = 0; i < 3; ++i) s_.error.forget(kAccBias + i, params_.acc_bias_sd_mps2 * params_.acc_bias_sd_mps2);
  forget_tilt(offset.squaredNorm() / (kStandardGravity_mps2 * kStandardGravity_mps2));
}

/// Gravity denies the gyroscope, or the detector goes on saying rest, and it sees further back than any motion that has
/// just begun: the offset has jumped. What the filter thought to know of it is void, and so is the turn that it made of
/// it since the last rest, when it was still right.
void AttitudeFilter::relearn_bias(const Vec3& rate_radps) noexcept {
  const Vec3 turned = mat(s_.R_world_body) * rate_radps * s_.since_rest_s;
  for (int i = 0; i < 3; ++i) {
    s_.error.forget(kGyrBias + i, params_.gyr_bias_sd_radps * params_.gyr_bias_sd_radps);
    s_.error.add_variance(kTheta + i, turned(i) * turned(i));
  }
  s_.rest_doubt_s = s_.since_gyr_jump_s = 0.0;
}

/// Of a turn about the vertical gravity says nothing. What the detector calls an offset may be a turntable: then the
/// heading goes on turning with it.
void AttitudeFilter::doubt_insistence(double time_s) noexcept {
  const double until_s = s_.insisted_s + time_s;
  s_.error.P()(kTheta + 2, kTheta + 2) +=
      s_.insisted_radps * s_.insisted_radps * (until_s * until_s - s_.insisted_s * s_.insisted_s);
  s_.insisted_s = until_s;
}

/// And the offset is what it was before.
void AttitudeFilter::end_insisting() noexcept {
  const Vec3 about = mat(s_.R_world_body).row(2) * s_.insisted_radps;
  s_.error.P().block<3, 3>(kGyrBias, kGyrBias) += about * about.transpose();
  s_.insisted_radps = 0.0;
}

/// At rest gravity shows the tilt itself: one that the covariance excludes is not known at all.
void AttitudeFilter::doubt_tilt(double time_s) noexcept {
  const Vec3 force = vec(s_.sums.motion.force) / time_s;
  const double g2 = kStandardGravity_mps2 * kStandardGravity_mps2;
  const double lean2 = force.head<2>().squaredNorm() / g2;
  const double expected = s_.error.tilt_rad2() + (s_.error.P().diagonal().segment<3>(kAccBias).sum() +
                                                  params_.acc_noise_mps2_rtHz * params_.acc_noise_mps2_rtHz / time_s) /
                                                     g2;
  s_.lean_s = lean2 > kRestLean * expected ? s_.lean_s + time_s : 0.0;
  if (s_.lean_s < kRestDoubt_s) return;
  for (int i = 0; i < 2; ++i) s_.error.add_variance(kTheta + i, lean2);
  s_.lean_s = 0.0;
}

}  // namespace stillpoint::fusion

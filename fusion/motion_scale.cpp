#include "fusion/motion_scale.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace stillpoint::fusion {
namespace {

constexpr double kMeanOver = 2.0;          ///< correlation times that the velocity is averaged over
constexpr double kSurprisingMotion = 9.0;  ///< chi-square of one: three standard deviations
constexpr double kLeftOver = 2.0;          ///< what the surprise is brought down to: one jump does not settle it
constexpr double kRideMemory_s = 20.0;     ///< a car stops at lights and goes on
constexpr double kLargest = 1e8;           ///< ten thousand times the usual speed
constexpr double kRide_mps2 = 2.0;         ///< what a car or a train gathers speed by
constexpr double kForceTime_s = 2.0;
constexpr double kForceNoise_mps2 = 0.15;  ///< offset of an accelerometer, and what two seconds leave of a motion
constexpr double kMostOdds = 6.0;          ///< log; nothing is certain
constexpr double kLasting_s = 5.0;         ///< no hand accelerates for longer
constexpr double kLastingLean = 0.3;       ///< of what is called a long acceleration, so much is a lean
constexpr double kUsual = 8.0;             ///< of a chi-square of two: no surprise
constexpr double kVehicleOdds = -3.5;      ///< log; one body in thirty is carried by a vehicle
constexpr double kLeastTilt_rad2 = 1e-4;   ///< half a degree: no filter is surer of its tilt in motion
constexpr double kExcused_s = 0.5;  ///< an offset leans the tilt once; who is surprised again and again is carried
constexpr double kExcusedMemory_s = 60.0;
constexpr double kCarried = 4.0;  ///< of s^2: twice as fast as a hand
constexpr double kSwing_s = 1.0;  ///< slower than a stride or a stroke of the arm
constexpr double kSwingMemory_s = 5.0;
constexpr double kBounceTime_s = 0.5;  ///< a runner's level speed, per axis, over the deviation of the force upwards
constexpr double kRunning2 = 16.0;     ///< m^2/s^2, per axis: 4 m/s
constexpr double kKnownOffset_radps = 0.0017;  ///< as a rest leaves it, and ten minutes of its walk: 0.1 deg/s
constexpr double kFirmOffset_radps = 0.01;     ///< deviation: what is known so well is not unlearnt by a stride
constexpr double kUpright_rad2 = 0.04;         ///< of the tilt: beyond it nobody knows where up is
constexpr double kSwingPeak2 = 9.0;  ///< a bound that a swing of that mean square seldom leaves: three deviations

void follow(double& mean, double x, double period_s, double memory_s) {
  mean += std::min(1.0, period_s / memory_s) * (x - mean);
}

}  // namespace

double MotionScale::time() const noexcept { return std::sqrt(scale_); }

bool MotionScale::carried() const noexcept { return scale_ > kCarried || excused_s_ > kExcused_s; }

void MotionScale::turn_back() noexcept {
  for (auto* mean : {&slow_velocity_mps_, &mean_velocity_mps_})
    for (double& v : *mean) v = -v;
}

void MotionScale::rest() noexcept {
  const double odds = log_odds_;
  *this = {};
  log_odds_ = odds;
  rested_ = offset_known_ = true;
}

double MotionScale::vehicle(double lean2, double tilt_rad2) const noexcept {
  // A lean that the filter's own variance makes unlikely is likelier a vehicle: Bayes, with the force's odds.
  const double unlike_lean = std::min(kMostOdds, 0.5 * lean2 / (tilt_rad2 + kLeastTilt_rad2));
  return 1.0 / (1.0 + std::exp(-(log_odds_ + unlike_lean + kVehicleOdds)));
}

Mat3 MotionScale::leaning_rad2(double tilt_rad2) const noexcept {
  const auto& f = lasting_force_mps2_;
  const Vec3 lean = Vec3(f[1], -f[0], 0.0) / kStandardGravity_mps2;
  const double surprise = lean.squaredNorm() / (tilt_rad2 + kLeastTilt_rad2);
  return kLastingLean * std::max(0.0, 1.0 - kUsual / surprise) * lean * lean.transpose();
}

void MotionScale::follow_swing(const Seen& seen, double usual_mps, double period_s) noexcept {
  // To and fro only: an attitude that leans lets the velocity run away slowly, and must not excuse itself by it.
  const double leaning = kStandardGravity_mps2 * kSwing_s;
  double swing = -leaning * leaning * seen.tilt_rad2;
  for (std::size_t i = 0; i < 2; ++i) {
    follow(slow_velocity_mps_[i], seen.velocity_mps[i], period_s, kSwing_s);
    const double fast = seen.velocity_mps[i] - slow_velocity_mps_[i];
    swing += 0.5 * fast * fast;
  }
  follow(swing_m2ps2_, std::max(0.0, swing), period_s, kSwingMemory_s);
  follow_bounce(seen, period_s);
  // A bound too wide costs the tilt little; one too tight teaches an offset that nobody knows yet the runner's rounds.
  const double unknown = seen.gyr_bias_rad2ps2 / (seen.gyr_bias_rad2ps2 + kFirmOffset_radps * kFirmOffset_radps);
  const double swings = std::max(kSwingPeak2 * swing_m2ps2_,
                                 unknown * std::min(kRunning2, kBounceTime_s * kBounceTime_s * bounce_m2ps4_));
  swing_ = std::clamp(swings / (usual_mps * usual_mps), 1.0, kLargest);
}

/// No lean makes a force that goes up and down. Who runs bounces.
void MotionScale::follow_bounce(const Seen& seen, double period_s) noexcept {
  if (seen.tilt_rad2 > kUpright_rad2) return;
  bounce_s_ = std::min(bounce_s_ + period_s, kSwingMemory_s);
  follow(mean_up_mps2_, seen.force_mps2[2], period_s, bounce_s_);
  const double bounce = seen.force_mps2[2] - mean_up_mps2_;
  follow(bounce_m2ps4_, bounce * bounce, period_s, bounce_s_);
}

void MotionScale::weigh(const std::array<double, 3>& force_mps2, double period_s) noexcept {
  force_s_ = std::min(force_s_ + period_s, kForceTime_s);
  const double blend = period_s / force_s_;
  for (std::size_t i = 0; i < 3; ++i) mean_force_mps2_[i] += blend * (force_mps2[i] - mean_force_mps2_[i]);
  const double level2 = mean_force_mps2_[0] * mean_force_mps2_[0] + mean_force_mps2_[1] * mean_force_mps2_[1];
  // An acceleration adds its square to the squared force; a tilt that is off only turns the force.
  const double of_vehicle = mean_force_mps2_[2] - kStandardGravity_mps2;
  const double of_tilt = std::sqrt(level2 + mean_force_mps2_[2] * mean_force_mps2_[2]) - kStandardGravity_mps2;
  const double variance = kForceNoise_mps2 * kForceNoise_mps2;
  const double gain = 0.5 * (of_tilt * of_tilt - of_vehicle * of_vehicle) / variance;
  log_odds_ += period_s / kForceTime_s * std::clamp(gain, -kMostOdds, kMostOdds) - period_s / kRideMemory_s * log_odds_;
  log_odds_ = std::clamp(log_odds_, -kMostOdds, kMostOdds);
}

double MotionScale::carried_rad2(double level_bias_rad2ps2) const noexcept {
  const double g2 = kStandardGravity_mps2 * kStandardGravity_mps2;
  const double unknown = level_bias_rad2ps2 / (level_bias_rad2ps2 + kKnownOffset_radps * kKnownOffset_radps);
  const double by_force = vehicle(0.0, 0.0), of_vehicle = carried() ? std::max(0.5, by_force) : by_force;
  const double ride2 = std::max(kRide_mps2 * kRide_mps2, vec(mean_force_mps2_).squaredNorm() - g2);
  return unknown * of_vehicle * ride2 / (2.0 * g2);
}

MotionScale::Lean MotionScale::observe(const Seen& seen, const Usual& usual, double period_s) noexcept {
  if (seen.gyr_bias_rad2ps2 > kKnownOffset_radps * kKnownOffset_radps) offset_known_ = false;
  weigh(seen.force_mps2, period_s);
  for (std::size_t i = 0; i < 2; ++i) follow(lasting_force_mps2_[i], seen.force_mps2[i], period_s, kLasting_s);
  follow_swing(seen, usual.speed_mps, period_s);
  const double blend = 1.0 - std::exp(-period_s / (kMeanOver * usual.time_s * time()));
  // Of a first-order process the mean with this memory keeps 1 / (1 + kMeanOver) of the variance.
  const double usual2 = usual.speed_mps * usual.speed_mps * scale_ / (1.0 + kMeanOver);
  double surprise = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    mean_velocity_mps_[i] += blend * (seen.velocity_mps[i] - mean_velocity_mps_[i]);
    surprise = std::max(surprise, mean_velocity_mps_[i] * mean_velocity_mps_[i] / (usual2 + seen.variance_m2ps2[i]));
  }
  scale_ = 1.0 + (scale_ - 1.0) * std::exp(-period_s / kRideMemory_s);
  Lean lean;
  excused_s_ *= std::exp(-period_s / kExcusedMemory_s);
  if (surprise > kSurprisingMotion) {
    const double level2 = mean_force_mps2_[0] * mean_force_mps2_[0] + mean_force_mps2_[1] * mean_force_mps2_[1];
    const double lean2 = level2 / (kStandardGravity_mps2 * kStandardGravity_mps2);
    const double of_vehicle = vehicle(lean2, seen.tilt_rad2);
    const bool may_lean = !offset_known_ || seen.turned_unseen;
    if (!rested_) excused_s_ += (1.0 - of_vehicle) * period_s;
    if (of_vehicle > 0.5 || excused_s_ > kExcused_s) scale_ = std::min(kLargest, scale_ * surprise / kLeftOver);
    if (may_lean) lean.share = (1.0 - of_vehicle) * blend;  // by what the hand has of the odds
    lean.tilt_rad = {mean_force_mps2_[1] / kStandardGravity_mps2, -mean_force_mps2_[0] / kStandardGravity_mps2};
    lean.velocity_mps = {-seen.velocity_mps[0], -seen.velocity_mps[1]};
    lean.any_way = !rested_;
  }
  if (!std::isfinite(scale_) || !std::isfinite(swing_) || !std::isfinite(log_odds_)) *this = {};
  return std::isfinite(lean.rad2()) ? lean : Lean{};
}

}  // namespace stillpoint::fusion

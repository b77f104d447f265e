// What the four quarters of a window say: RestDetector's statistics and verdicts (docs/math/rest.md).
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calib_online/rest_detector.h"
#include "calib_online/slow_change.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr int kLeastSamples = 12;                    // three a quarter
constexpr double kAccDrift_mps2 = 0.01;              // 1 mg: what an accelerometer may drift between anchor and now
constexpr double kMagDrift_uT = 0.3;                 // the same for the field and its sensor
constexpr double kAccSlope_mps2 = 0.005;             // slow wander of the readings inside a window
constexpr double kSignificant = 5.0;                 // sd; one test a window, a day has 4e4 of them
constexpr double kSlowTurn_radps = 0.09;             // 5 deg/s: faster, and the lever arm of the sensor is felt
constexpr double kFastTurn_radps = 0.5;              // 30 deg/s: no offset, and 0.25 m/s^2 a metre off the axis
constexpr double kLeastNorm = 0.5, kMostNorm = 2.0;  // of gravity: beyond, no wrong range explains it
constexpr double kNoisy = 1.0;                       // sd over lattice; twenty equal readings: 5e-9 by chance
constexpr double kClippedShare = 0.1;                // of a window; single clipped readings are shocks

}  // namespace

std::string_view name(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kNone:
      return "none";
    case Refusal::kFilling:
      return "filling";
    case Refusal::kNoAccelerometer:
      return "no accelerometer";
    case Refusal::kGap:
      return "gap";
    case Refusal::kStuck:
      return "stuck";
    case Refusal::kClipped:
      return "clipped";
    case Refusal::kVibrating:
      return "vibrating";
    case Refusal::kSwaying:
      return "swaying";
    case Refusal::kTurning:
      return "turning";
    case Refusal::kLinearAcceleration:
      return "linear acceleration";
    case Refusal::kNotGravity:
      return "not gravity";
    case Refusal::kUnknownRate:
      return "unknown rate";
  }
  return "?";
}

/// From block means: correlated noise and vibration are inside, which sigma^2/n would miss.
Mat3 RestDetector::covariance_of_mean(std::size_t w, const Vec3& mean_in_ref) const noexcept {
  Mat3 sum = Mat3::Zero();
  int blocks = 0;
  for (const auto& quarter : quarters_) {
    const Triad& t = quarter.triad[w];
    for (std::size_t b = 0; b < kBlocks; ++b) {
      if (t.n[b] == 0) continue;
      const Vec3 d = t.block_ref[b] / t.n[b] - mean_in_ref;
      sum += d * d.transpose();
      ++blocks;
    }
  }
  if (blocks > 1) sum /= static_cast<double>(blocks) * (blocks - 1);
  return sum;
}

RestDetector::Summary RestDetector::summarise(std::size_t w) const noexcept {
  Summary s;
  const Mat3 R_middle_ref = quarters_[kQuarters / 2].chain.rotation.q.toRotationMatrix().transpose();
  std::array<Vec3, kQuarters> mean, mean_ref;
  Vec3 total = Vec3::Zero(), total_ref = Vec3::Zero(), sq = Vec3::Zero(), raw_step_sq = Vec3::Zero();
  double step_sq = 0.0;
  int steps = 0;
  for (std::size_t q = 0; q < kQuarters; ++q) {
    const Triad& t = quarters_[q].triad[w];
    const int n = t.count();
    if (n == 0) return Summary{};
    Vec3 sum = Vec3::Zero(), sum_ref = Vec3::Zero();
    for (std::size_t b = 0; b < kBlocks; ++b) {
      sum += t.block[b];
      sum_ref += t.block_ref[b];
    }
    mean[q] = sum / n;
    mean_ref[q] = sum_ref / n;
    total += sum;
    total_ref += sum_ref;
    sq += t.sum_sq;
    step_sq += t.step_sq;
    raw_step_sq += t.raw_step_sq;
    steps += t.steps;
    s.n += n;
    s.clipped += t.clipped;
    for (int axis = 0; axis < 3; ++axis) {
      const double least = t.least_step[axis];
      if (least > 0.0 && (s.least_step[axis] == 0.0 || least < s.least_step[axis])) s.least_step[axis] = least;
    }
  }
  s.mean = total / s.n;
  const Vec3 mean_in_ref = total_ref / s.n;
  s.mean_still = w == kGyrIndex ? s.mean : Vec3(R_middle_ref * mean_in_ref);
  // About whichever mean is steadier: an offset of the gyroscope that is not known yet turns what really rests.
  s.power = std::max(0.0, sq.sum() / s.n - std::max(mean_in_ref.squaredNorm(), s.mean.squaredNorm()));
  s.white_var = steps > 0 ? step_sq / (6.0 * steps) : 0.0;  // mean over the axes of half the mean square step
  if (steps > 0) s.noise_sd = (raw_step_sq / (2.0 * steps)).cwiseSqrt();
  for (int axis = 0; axis < 3; ++axis)
    s.constant[static_cast<std::size_t>(axis)] = steps > 0 && raw_step_sq[axis] == 0.0;
  const SlowChange change(mean);
  s.spread_sq = change.squared();
  s.spread_still_sq = SlowChange(mean_ref).squared();
  // A steady turn moves the reading across itself, never along: that part of the slope is taken out.
  const double along = s.mean.dot(change.slope);
  s.spread_turn_sq = along * along / std::max(1e-12, s.mean.squaredNorm()) + change.curvature.squaredNorm();
  s.spread_noise_sq = 6.0 * s.white_var / (0.25 * s.n);
  s.slope = change.slope / (std::sqrt(5.0) * params_.window_s / kQuarters);  // least squares over the four quarters
  s.cov = covariance_of_mean(w, mean_in_ref);
  if (w != kGyrIndex) s.cov = (R_middle_ref * s.cov * R_middle_ref.transpose()).eval();
  s.cov += 1e-12 * Mat3::Identity();
  return s;
}

std::array<bool, 3> RestDetector::Summary::noisier_than_lattice() const noexcept {
  std::array<bool, 3> out{};
  for (int axis = 0; axis < 3; ++axis) out[static_cast<std::size_t>(axis)] = noise_sd[axis] > kNoisy * least_step[axis];
  return out;
}

/// An axis without noise is a coarse one at rest, or stuck (at its limit, too): stuck when it was noisier than its
/// lattice before, or an axis beside it is, or when all that the sensor measures of motion stands still at once. One
/// that is zero throughout is not there.
void RestDetector::judge_faults(Evidence& e) const noexcept {
  const auto still = [](const Summary& s) { return s.constant[0] && s.constant[1] && s.constant[2]; };
  const bool both = still(e.triad[kAccIndex]) && still(e.triad[kGyrIndex]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Summary& s = e.triad[k];
    if (s.n < kLeastSamples) continue;
    bool stuck = both && k != kMagIndex;
    const std::array<bool, 3> noisier = s.noisier_than_lattice();
    const bool fine = noisier[0] || noisier[1] || noisier[2];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool there = last_raw_[k][static_cast<Eigen::Index>(axis)] != 0.0;
      stuck = stuck || (s.constant[axis] && (noisy_[k][axis] || (fine && there)));
    }
    if (stuck) e.stuck = static_cast<std::uint8_t>(e.stuck | kTriadBits[k]);
    if (s.clipped > kClippedShare * s.n) e.clipped = static_cast<std::uint8_t>(e.clipped | kTriadBits[k]);
  }
}

Refusal RestDetector::judge_force(Evidence& e, const CalibrationSnapshot& calibration) const noexcept {
  const Summary& acc = e.triad[kAccIndex];
  const Summary& gyr = e.triad[kGyrIndex];
  if (acc.n == 0) return Refusal::kNoAccelerometer;
  if (acc.n < kLeastSamples) return Refusal::kFilling;
  if (acc.clipped > 0) return Refusal::kClipped;
  if ((e.stuck & kAcc) != 0) return Refusal::kStuck;
  if (acc.power > params_.vibration_mps2 * params_.vibration_mps2) return Refusal::kVibrating;
  if (gyr.n > 0 && gyr.power > params_.vibration_radps * params_.vibration_radps) return Refusal::kVibrating;
  const double limit = params_.acc_spread_mps2 * params_.acc_spread_mps2 + acc.spread_noise_sq;
  e.use_still = gyr.n > 0 && acc.spread_still_sq < acc.spread_sq;
  const bool still = acc.spread_sq <= limit;
  const bool still_turned = e.use_still && acc.spread_still_sq <= limit && gyr.mean.norm() < kSlowTurn_radps;
  if (!still && !still_turned) {
    return acc.spread_turn_sq <= limit ? Refusal::kTurning : Refusal::kLinearAcceleration;
  }
  if (gyr.n > 0 && gyr.mean.norm() > kFastTurn_radps) return Refusal::kTurning;
  const double norm_sd = calibration.acc.norm_sd > 0 ? calibration.acc.norm_sd / params_.gravity_mps2 : 0.0;
  const double norm = (e.use_still ? acc.mean_still : acc.mean).norm() / params_.gravity_mps2;
  if (norm < kLeastNorm || norm > kMostNorm) return Refusal::kNotGravity;
  e.not_gravity = std::abs(norm - 1.0) > std::max(params_.norm_tolerance, kSignificant * norm_sd);
  return Refusal::kNone;
}

Refusal RestDetector::judge_rate(Evidence& e, const CalibrationSnapshot& calibration) noexcept {
  const Summary& acc = e.triad[kAccIndex];
  const Summary& gyr = e.triad[kGyrIndex];
  const double limit_gyr = params_.gyr_spread_radps * params_.gyr_spread_radps;
  if (gyr.n > 0 && gyr.spread_sq > limit_gyr + gyr.spread_noise_sq) return Refusal::kSwaying;
  const double limit_acc = params_.acc_spread_mps2 * params_.acc_spread_mps2 + acc.spread_noise_sq;
  const bool turning = turns(e);
  if (turning || acc.spread_sq > limit_acc) return Refusal::kTurning;
  if (e.not_gravity) return Refusal::kNotGravity;
  return rate_beyond_known_bias(e, calibration) ? Refusal::kUnknownRate : Refusal::kNone;
}

/// Rate of turn from the change of gravity and field, u' = u x w: least squares over both, inside the window and from
/// the anchor (R4). `turn_cov` is what remains possible; a turn nothing observes keeps the sd `unseen_turn_sd_radps`.
bool RestDetector::turns(Evidence& e) noexcept {
  Mat3 information = Mat3::Zero();
  Vec3 rhs = Vec3::Zero();
  const double quarter_s = params_.window_s / kQuarters;
  const double baseline_s = anchor_.set ? in_seconds(quarters_.back().t_last_ns - anchor_.t_ns) : 0.0;
  for (const std::size_t k : {kAccIndex, kMagIndex}) {
    const Summary& s = e.triad[k];
    if (s.n == 0) continue;
    const double wander = k == kAccIndex ? kAccSlope_mps2 : kMagDrift_uT;
    const double drift = k == kAccIndex ? kAccDrift_mps2 : kMagDrift_uT;
    double var = s.white_var / (0.25 * s.n) / (5.0 * quarter_s * quarter_s) +
                 wander * wander / (params_.window_s * params_.window_s);
    Vec3 rate = s.slope;
    if (baseline_s > 0 && anchor_.has[k]) {
      const double var_base = ((anchor_.cov[k] + s.cov).trace() / 3.0 + drift * drift) / (baseline_s * baseline_s);
      if (var_base < var) {
        var = var_base;
        rate = (s.mean - anchor_.mean[k]) / baseline_s;
      }
    }
    Mat3 A;
    A << 0, -s.mean.z(), s.mean.y(), s.mean.z(), 0, -s.mean.x(), -s.mean.y(), s.mean.x(), 0;
    information += A.transpose() * A / var;
    rhs += A.transpose() * rate / var;
  }
  const double prior_var = params_.unseen_turn_sd_radps * params_.unseen_turn_sd_radps;
  const Mat3 bound = (information + Mat3::Identity() / prior_var).inverse();
  // The test leans on no prior: only the axis that nothing observes is held.
  const Mat3 free = (information + Mat3::Identity()).inverse();
  const Vec3 turn = free * rhs;
  e.turn = turn;
  e.turn_information = information;
  // A turn below significance is not refused, but what is seen of it is possible.
  e.turn_cov = bound + turn * turn.transpose();
  if (turn.norm() > params_.turn_radps && turn.dot(information * turn) > kSignificant * kSignificant) {
    seen_turn_ = turn;
    return true;
  }
  // Once seen, a turn is over when it would be seen and is not.
  const double seen = seen_turn_.norm();
  if (seen > 0.0) {
    const Vec3 axis = seen_turn_ / seen;
    const bool over = kSignificant * kSignificant * axis.dot(free * axis) < seen * seen;
    if (!over) return true;
    seen_turn_ = Vec3::Zero();
  }
  return false;
}

/// Where neither gravity nor field can tell, only what is known of the gyro's bias can.
bool RestDetector::rate_beyond_known_bias(const Evidence& e, const CalibrationSnapshot& calibration) const noexcept {
  const Summary& gyr = e.triad[kGyrIndex];
  if (gyr.n == 0 || calibration.gyr.status != CalibrationStatus::kOk) return false;
  const double prior_var = params_.unseen_turn_sd_radps * params_.unseen_turn_sd_radps;
  // R7: a rate that gravity and the field contradict is no turn, but for what it holds about an axis they do not show.
  const Vec3 excess = gyr.mean - e.turn;
  const bool contradicted = excess.dot(e.turn_information * excess) > kSignificant * kSignificant;
  const Vec3 unseen = contradicted
                          ? Vec3((Mat3::Identity() + gyr.mean.squaredNorm() * e.turn_information).inverse() * gyr.mean)
                          : Vec3(e.turn_cov * gyr.mean / prior_var);
  const double size = unseen.norm();
  const Vec3 axis = unseen / std::max(size, 1e-12);
  const Mat3 known = mat(calibration.gyr.bias_covariance) + gyr.cov;
  return size > params_.turn_radps && size * size > kSignificant * kSignificant * axis.dot(known * axis);
}

}  // namespace stillpoint::calib

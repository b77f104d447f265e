// What RestDetector hands on: the window, its rotation since the one before, the anchor for the next
// (docs/math/rest.md; docs/math/gyro.md, Y3 and Y4).
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib_online/rest_detector.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kAnchorAngle_rad = 0.3;       // beyond, the chord of a turn is no longer its arc
constexpr double kAnchorAge_s = 120.0;         // longer, and the drift of the sensors looks like a turn
constexpr double kScaleError = 0.005;          // of a gyro before its matrix is learnt
constexpr double kGyrNoise_radps_rtHz = 2e-4;  // a consumer gyro's 0.01 deg/s/sqrt(Hz)

}  // namespace

/// A fault is told when it begins and when it ends, without waiting for the next rest.
std::optional<Window> RestDetector::tell_faults(const Evidence& e) noexcept {
  if (e.stuck == told_stuck_ && e.clipped == told_clipped_) return std::nullopt;
  Window w;
  w.t_start_ns = quarters_.front().t_first_ns;
  w.t_end_ns = quarters_.back().t_last_ns;
  w.refusal = last_refusal_;
  w.temp_degC = e.temp_degC;
  w.stuck = told_stuck_ = e.stuck;
  w.clipped = told_clipped_ = e.clipped;
  return w;
}

/// The anchor stays through a steady turn: it is what shows the turn. Sway starts anew.
void RestDetector::keep_anchor(const Evidence& e, Refusal rate) noexcept {
  const std::int64_t now_ns = quarters_.back().t_last_ns;
  const double age_s = in_seconds(now_ns - anchor_.t_ns);
  if (rate == Refusal::kSwaying) {
    anchor_.set = false;
    seen_turn_ = Vec3::Zero();
    return;
  }
  if (anchor_.set && age_s < kAnchorAge_s && age_s * seen_turn_.norm() < kAnchorAngle_rad) return;
  anchor_.set = true;
  anchor_.t_ns = now_ns;
  for (std::size_t k = 0; k < 3; ++k) {
    anchor_.mean[k] = e.triad[k].mean;
    anchor_.cov[k] = e.triad[k].cov;
    anchor_.has[k] = e.triad[k].n > 0;
  }
}

/// A mean of rounded readings is off by up to half a step, as long as one step of the bias would take; noise of sd s
/// makes exp(-2 pi^2 s^2 / step^2) of that. What is seen of the noise holds what rounding adds to it.
Array3 RestDetector::rounding_var(std::size_t triad) const noexcept {
  constexpr double kRoundingInNoise = 1.0 / 6.0;  // of a squared step, at most where the mean is far off
  Array3 out{};
  for (int axis = 0; axis < 3; ++axis) {
    const double step_sq = lattice_[triad][axis] * lattice_[triad][axis];
    if (step_sq == 0.0) continue;
    double noise = 0.0, noisiest = 0.0;  // of the quarters; one of them may hold the last step of a motion
    for (const Quarter& q : quarters_) {
      const Triad& t = q.triad[triad];
      const double of_quarter = t.raw_step_sq[axis] / (2.0 * std::max(1, t.steps) * step_sq);
      noise += of_quarter / (kQuarters - 1);
      noisiest = std::max(noisiest, of_quarter);
    }
    const double carried = std::max(0.0, noise - noisiest / (kQuarters - 1) - kRoundingInNoise);
    out[static_cast<std::size_t>(axis)] =
        step_sq / 12.0 * std::exp(-4.0 * std::numbers::pi * std::numbers::pi * carried);
  }
  return out;
}

Window RestDetector::make_window(const Evidence& e, Refusal rate, const CalibrationSnapshot& calibration) noexcept {
  Window w;
  w.t_start_ns = quarters_.front().t_first_ns;
  w.t_end_ns = quarters_.back().t_last_ns;
  w.refusal = rate;
  w.temp_degC = e.temp_degC;
  const std::array<const TriadCalibration*, 3> used{&calibration.acc, &calibration.gyr, &calibration.mag};
  const std::array<Array3*, 3> means{&w.acc_mps2, &w.gyr_radps, &w.mag_uT};
  const std::array<Array9*, 3> covs{&w.acc_cov, &w.gyr_cov, &w.mag_cov};
  for (std::size_t k = 0; k < 3; ++k) {
    const bool steady = rate == Refusal::kNone || rate == Refusal::kNotGravity || rate == Refusal::kUnknownRate;
    if (e.triad[k].n == 0 || (k == kGyrIndex && !steady)) continue;
    if (((e.stuck | e.clipped) & kTriadBits[k]) != 0) continue;
    const std::array<bool, 3> fine = e.triad[k].noisier_than_lattice();
    for (int axis = 0; axis < 3; ++axis) {
      noisy_[k][static_cast<std::size_t>(axis)] |= fine[static_cast<std::size_t>(axis)];
    }
    w.has = static_cast<std::uint8_t>(w.has | kTriadBits[k]);
    // Back to raw readings: the window must not depend on the calibration that was in force when it was seen.
    const Mat3 H_inv = mat(used[k]->matrix).inverse();
    const Vec3 u = e.use_still && k != kGyrIndex ? e.triad[k].mean_still : e.triad[k].mean;
    *means[k] = array(Vec3(H_inv * u + used[k]->bias_at(e.temp_degC)));
    *covs[k] = array(Mat3(H_inv * e.triad[k].cov * H_inv.transpose()));
    // Gravity falls on another place of the lattice in each attitude; the offset of a gyroscope always on the same.
    if (k == kAccIndex) mat(*covs[k]).diagonal() += vec(rounding_var(k));
  }
  for (const auto& q : quarters_) {
    w.samples += static_cast<std::uint32_t>(q.samples);
    if (q.temp_count > 0) w.has = static_cast<std::uint8_t>(w.has | kTemp);
  }
  w.turn_cov = array(e.turn_cov);
  if (e.triad[kGyrIndex].n > 0) w.gyr_rounding_var = rounding_var(kGyrIndex);
  w.stuck = told_stuck_ = e.stuck;
  w.clipped = told_clipped_ = e.clipped;
  hand_on_rotation(w, calibration);
  held_ = Held{};
  for (std::size_t k = 0; k < 2; ++k) {
    held_.has[k] = (w.has & kTriadBits[k]) != 0;
    held_.mean[k] = vec(*means[k]);
    held_.drift[k] = Vec3::Zero();
    held_.noise_sd[k] = std::sqrt(e.triad[k].white_var);
  }
  w.moved = moved_;
  moved_ = false;
  filled_ = 0;
  return w;
}

/// The chain is cut at the middle of this window; what follows the middle starts the next chain (Y4).
void RestDetector::hand_on_rotation(Window& w, const CalibrationSnapshot& calibration) noexcept {
  const Chain& at_middle = quarters_[kQuarters / 2].chain;
  w.rotation_s = at_middle.duration_s;
  w.rotation_path_rad = at_middle.angle_rad;
  w.rotation_valid = !at_middle.broken && at_middle.duration_s > 0.0 && at_middle.duration_s <= params_.rotation_max_s;
  const Preintegrated& turned = at_middle.rotation;
  w.q_previous_this = {turned.q.w(), turned.q.x(), turned.q.y(), turned.q.z()};
  const Mat3 bias_cov = calibration.gyr.bias_covariance[0] > 0
                            ? Mat3(mat(calibration.gyr.bias_covariance))
                            : Mat3(params_.gyr_bias_sd_radps * params_.gyr_bias_sd_radps * Mat3::Identity());
  const double white = kGyrNoise_radps_rtHz * kGyrNoise_radps_rtHz * at_middle.duration_s;
  const double scale = kScaleError * at_middle.angle_rad;
  w.rotation_cov =
      array(Mat3(turned.J_bias * bias_cov * turned.J_bias.transpose() + (white + scale * scale) * Mat3::Identity()));
  Eigen::Map<Mat39>(w.d_rotation_d_matrix.data()) = turned.J;
  w.d_rotation_d_bias = array(turned.J_bias);
  w.gyr_matrix_used = calibration.gyr.matrix;
  w.gyr_bias_used = array(calibration.gyr.bias_at(w.temp_degC));

  Chain next;
  next.rotation = chain_.rotation.after(turned);
  next.duration_s = chain_.duration_s - at_middle.duration_s;
  next.angle_rad = chain_.angle_rad - at_middle.angle_rad;
  next.broken = !has_last_rate_;
  chain_ = next;
}

}  // namespace stillpoint::calib

// The gyroscope's part of OnlineCalibrator: bias from stretches of rest, matrix from the turns between windows.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calib_online/online_calibrator.h"
#include "core/so3.h"

namespace stillpoint::calib {
namespace {

constexpr double kGate = 4.0;                       // sd; beyond, a window is set aside
constexpr std::uint32_t kRunToWiden = 8;            // windows set aside in a row: not outliers, the sensor changed
constexpr double kStretch_s = 900.0;                // a turn is taken to last no longer
constexpr double kStretchTemp_K = 4.0;              // beyond, one mean says too little of the slope
constexpr double kSingle_radps = 0.1 * kRadPerDeg;  // a stretch of one window may be no rest at all; fades as 1/n
constexpr double kKnownAgain = 0.25;                // of the prior's sd: a replaced sensor's bias is known again
constexpr double kHuber = 2.0;                      // sd; beyond, a window counts less
constexpr double kLongestTurn_rad = 15.0;           // beyond, what is not in the matrix outweighs it
constexpr double kLeastTurn_rad = 0.2;              // smaller turns say nothing of the matrix
constexpr double kNonlinearity = 0.002;             // of a turn: what a constant matrix cannot describe
constexpr double kWhite_radps_rtHz = 2e-4;          // a consumer gyro's 0.01 deg/s/sqrt(Hz)
constexpr double kDirectionFloor = 0.002;           // rad, of a window's direction
constexpr double kFactoryDirection = 0.03;          // rad, before the accelerometer is learnt

double squared(double v) { return v * v; }

}  // namespace

/// Y6: gravity before and after a turn, against what the gyroscope says of the turn.
bool OnlineCalibrator::absorb_turn(const Window& w) noexcept {
  if ((w.has & kAcc) == 0) return false;
  const Vec3 u = snapshot_.acc.apply(w.acc_mps2, w.temp_degC).normalized();
  const Vec3 u_before = snapshot_.acc.apply(s_.previous_acc_mps2, s_.previous_temp_degC).normalized();
  const bool had = s_.has_previous;
  s_.previous_acc_mps2 = w.acc_mps2;
  s_.previous_temp_degC = w.temp_degC;
  s_.has_previous = u.allFinite();
  if (!had || !u.allFinite() || !w.rotation_valid) return false;
  const Quat q(w.q_previous_this[0], w.q_previous_this[1], w.q_previous_this[2], w.q_previous_this[3]);
  if (w.rotation_path_rad < kLeastTurn_rad || w.rotation_path_rad > kLongestTurn_rad) return false;
  const double known = snapshot_.acc.norm_sd > 0.0 ? snapshot_.acc.norm_sd / params_.gravity_mps2 : kFactoryDirection;
  const double direction_var = squared(std::min(known, kFactoryDirection)) + squared(kDirectionFloor);
  const Mat3 J_bias = mat(w.d_rotation_d_bias);
  const Mat3 rotation_cov =
      J_bias * mat(snapshot_.gyr.bias_covariance) * J_bias.transpose() +
      (squared(kWhite_radps_rtHz) * w.rotation_s + squared(kNonlinearity * w.rotation_path_rad)) * Mat3::Identity();
  const Mat39 J = Eigen::Map<const Mat39>(w.d_rotation_d_matrix.data());
  const Mat3 R = q.toRotationMatrix();
  const auto& prior = params_.gyro_matrix;
  const GyroMatrixFit before = solve(s_.turns, mat(factory_.gyr.matrix), prior.scale_sd, prior.cross_sd);
  const Mat39 M = skew(Vec3(R.transpose() * u_before)) * J;
  const Vec3 e = u - R.transpose() * u_before - M * (rows_of(before.H) - rows_of(mat(w.gyr_matrix_used)));
  const Mat3 S = M * before.covariance * M.transpose() + 2.0 * direction_var * Mat3::Identity() + rotation_cov;
  if (e.dot(S.inverse() * e) > 3.0 * squared(kGate)) return false;
  s_.turns.add_direction(u_before, u, R, J, mat(w.gyr_matrix_used), direction_var, rotation_cov);
  return publish_gyr_matrix();
}

bool OnlineCalibrator::publish_gyr_matrix() noexcept {
  const auto& prior = params_.gyro_matrix;
  const GyroMatrixFit fit = solve(s_.turns, mat(factory_.gyr.matrix), prior.scale_sd, prior.cross_sd);
  if (fit.status != FitStatus::kOk) return false;
  s_.gyr_matrix_sd = std::sqrt(fit.covariance.trace() / 9.0);
  snapshot_.gyr.matrix = s_.turns.segments > 0 ? array(fit.H) : factory_.gyr.matrix;
  return true;
}

bool OnlineCalibrator::absorb_gyr(const Window& w) noexcept {
  const double age_s = static_cast<double>(w.t_end_ns - s_.stretch_start_ns) * kSecondsPerNs;
  if (s_.stretch_windows > 0 &&
      (w.moved || age_s > kStretch_s || std::abs(w.temp_degC - s_.stretch_temp_degC) > kStretchTemp_K)) {
    commit_stretch();
    gyr_.predict(age_s);
  }
  const double t = tau(w.temp_degC, factory_.gyr);
  const Vec3 rate = vec(w.gyr_radps) - factory_.gyr.bias_at(w.temp_degC);
  if (!rate.allFinite()) return false;
  const GyrFilter present = with_stretch();
  const Vec3 e = rate - present.at(t, t * t);
  const Mat3 S = present.covariance_at(t, t * t) + mat(w.gyr_cov) + mat(w.turn_cov) +
                 squared(3.0 * params_.gyroscope.mean_floor_radps) * Mat3::Identity();
  if (e.dot(S.inverse() * e) > 3.0 * kGate * kGate) {
    if (++s_.gyr_rejected_run < kRunToWiden) return false;
    s_.gyr_rejected_run = 0;
    commit_stretch();
    gyr_.widen(1.0);
    s_.gyr_replaced = true;
    s_.turns = {};
    publish_gyr_matrix();
    publish_gyr(w.temp_degC);
    return true;
  }
  s_.gyr_rejected_run = 0;
  if (s_.stretch_windows == 0) {
    s_.stretch_start_ns = w.t_end_ns;
    s_.stretch_temp_degC = w.temp_degC;
    s_.stretch_turn_cov = w.turn_cov;
    s_.stretch_rate = {};
    s_.stretch_cov = {};
    s_.stretch_tau = s_.stretch_tau2 = 0.0;
  }
  const double n = ++s_.stretch_windows;
  // Huber, against the stretch so far: one pushed window must not carry a mean of many.
  const double surprise =
      n > 1 ? (rate - vec(s_.stretch_rate)).norm() / std::sqrt(mat(w.gyr_cov).trace() + squared(kSingle_radps / n))
            : 0.0;
  vec(s_.stretch_rate) += (rate - vec(s_.stretch_rate)) / (n * std::max(1.0, surprise / kHuber));
  mat(s_.stretch_cov) += (mat(w.gyr_cov) - mat(s_.stretch_cov)) / n;
  s_.stretch_tau += (t - s_.stretch_tau) / n;
  s_.stretch_tau2 += (t * t - s_.stretch_tau2) / n;
  if (mat(w.turn_cov).trace() < mat(s_.stretch_turn_cov).trace()) s_.stretch_turn_cov = w.turn_cov;
  ++s_.gyr_windows;
  publish_gyr(w.temp_degC);
  return true;
}

/// R6: the whole stretch is one measurement, its error that of the mean and of the turn that could hide in it. A rate
/// that surprises in a direction where a turn could hide is taken for half a turn, so that no turn is learnt beyond 2
/// sd.
GyrFilter OnlineCalibrator::with_stretch() const noexcept {
  GyrFilter out = gyr_;
  if (s_.stretch_windows == 0) return out;
  const Mat3 turn = mat(s_.stretch_turn_cov);
  const double largest = turn.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  const Vec3 surprise = vec(s_.stretch_rate) - gyr_.at(s_.stretch_tau, s_.stretch_tau2);
  const Vec3 hidden = largest > 0 ? Vec3(turn * surprise / largest) : Vec3(Vec3::Zero());
  const double n = s_.stretch_windows;
  const Mat3 covariance = mat(s_.stretch_cov) / n + turn + 0.25 * hidden * hidden.transpose() +
                          squared(kSingle_radps / n) * Mat3::Identity();
  out.update(vec(s_.stretch_rate), covariance, s_.stretch_tau, s_.stretch_tau2);
  return out;
}

void OnlineCalibrator::commit_stretch() noexcept {
  if (s_.stretch_windows == 0) return;
  gyr_ = with_stretch();
  s_.stretch_windows = 0;
}

void OnlineCalibrator::publish_gyr(double temp_degC) noexcept {
  const GyrFilter present = with_stretch();
  const double t = tau(temp_degC, factory_.gyr);
  Mat3 c = present.polynomial();
  const Vec3 now = present.at(t, t * t);
  const auto follows =
      present.follows_temperature(tau(s_.temp_min_degC, factory_.gyr), tau(s_.temp_max_degC, factory_.gyr));
  for (int axis = 0; axis < 3; ++axis)
    if (!follows[static_cast<std::size_t>(axis)]) c.row(axis) << now[axis], 0.0, 0.0;
  const double s = kTempScale_K;
  TriadCalibration& out = snapshot_.gyr;
  out.bias = array(Vec3(vec(factory_.gyr.bias) + c.col(0)));
  out.bias_per_K = array(Vec3(vec(factory_.gyr.bias_per_K) + c.col(1) / s));
  out.bias_per_K2 = array(Vec3(vec(factory_.gyr.bias_per_K2) + c.col(2) / (s * s)));
  out.temp_min_degC = s_.temp_min_degC;
  out.temp_max_degC = s_.temp_max_degC;
  const Mat3 P = present.covariance_at(t, t * t);
  out.bias_covariance = array(P);
  out.norm_sd = std::sqrt(P.trace() / 3.0);
  out.windows = s_.gyr_windows;
  s_.gyr_replaced = s_.gyr_replaced && out.norm_sd > kKnownAgain * params_.gyroscope.bias_sd_radps;
  out.status = s_.gyr_replaced      ? CalibrationStatus::kReplaced
               : s_.gyr_windows > 0 ? CalibrationStatus::kOk
                                    : CalibrationStatus::kTooFewWindows;
}

}  // namespace stillpoint::calib

/// What the filter makes of a calibration: how far it can be trusted, and what changes with another one.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"
#include "fusion/attitude_filter.h"

namespace stillpoint::fusion {
namespace {

/// Where an element of a matrix that the filter holds column by column stands in a calibration's.
std::size_t by_rows(int element) { return static_cast<std::size_t>(3 * (element % 3) + element / 3); }

}  // namespace

/// (A35) The calibration knows the matrix by gravity before and after turns, far better than a heading that nothing
/// else sees. What it says is no rest evidence; it is taken when it is twice as sure as what is known, so each turn
/// counts little more than once, or when it contradicts that.
void AttitudeFilter::take_gyr_matrix(const TriadCalibration& gyr) noexcept {
  constexpr double kSurer = 0.25, kContradicts = 9.0;
  if (gyr.matrix_sd == Array9{} || params_.gyr_matrix_sd == 0.0 || !s_.has_attitude || s_.denied_s > 0.0) return;
  for (int i = 0; i < kOfGyrMatrix; ++i) {
    const double sd = gyr.matrix_sd[by_rows(i)];
    const auto at = static_cast<std::size_t>(i);
    const double off = s_.x.gyr_matrix[at], known2 = s_.error.gyr_matrix_variance(i, s_.gyr_unlearnt2[at]);
    const bool contradicts = off * off > kContradicts * (known2 + sd * sd);
    if (sd * sd > kSurer * known2 && !contradicts) continue;
    if (contradicts) s_.error.forget(kGyrMatrix + i, off * off);
    s_.error.learn_gyr_matrix(i, -off, sd * sd, s_.gyr_unlearnt2[at]);
  }
  inject();
}

/// (A40) Many attitudes have told the calibration of the offset: of what is left, and of the tilt that was taken for
/// it, it knows more than the filter. Taken as in (A35).
void AttitudeFilter::take_acc_bias(const TriadCalibration& acc) noexcept {
  constexpr double kSurer = 0.25, kContradicts = 9.0;
  if (acc.bias_covariance == Array9{} || !s_.has_attitude || s_.denied_s > 0.0) return;
  const Mat3 stated = mat(acc.matrix) * mat(acc.bias_covariance) * mat(acc.matrix).transpose();
  for (int i = 0; i < 3; ++i) {
    const int at = kAccBias + i;
    const double off = s_.x.acc_bias_mps2[static_cast<std::size_t>(i)], known2 = s_.error.P()(at, at);
    const bool contradicts = off * off > kContradicts * (known2 + stated(i, i));
    if (stated(i, i) > kSurer * known2 && !contradicts) continue;
    if (contradicts) s_.error.forget(at, off * off);
    s_.error.update(at, -off, stated(i, i));
  }
  inject();
}

void AttitudeFilter::know(const CalibrationSnapshot& calibration) noexcept {
  // Gravity's length tells a matrix but for a turn: how the sensor sits in its housing stays as little known as it was.
  if (calibration.acc.status == CalibrationStatus::kOk && calibration.acc.norm_sd > 0.0)
    known_.acc_matrix_sd = std::min(params_.acc_matrix_sd, std::hypot(calibration.acc.norm_sd / kStandardGravity_mps2,
                                                                      params_.acc_matrix_sd / std::numbers::sqrt2));
  if (calibration.gyr.matrix_sd == Array9{}) return;
  for (int i = 0; i < kOfGyrMatrix; ++i)
    known_.gyr_matrix_sd[static_cast<std::size_t>(i)] =
        std::min(params_.gyr_matrix_unlearnt_sd, calibration.gyr.matrix_sd[by_rows(i)]);
}

void AttitudeFilter::rebase(const CalibrationSnapshot& from, const CalibrationSnapshot& to) noexcept {
  // (A14) u' = H' (y - B') with y = H^-1 u + B, so u' = K u + c. At the present temperature the sum of both parts stays
  // what it was; how B' changes with temperature from here on passes through.
  const auto change = [this](const TriadCalibration& was, const TriadCalibration& is, Mat3& K, Vec3& c) {
    K = mat(is.matrix) * mat(was.matrix).inverse();
    c = mat(is.matrix) * (was.bias_at(s_.temp_degC) - is.bias_at(s_.temp_degC));
    return K.allFinite() && c.allFinite() && std::abs(K.determinant()) > 1e-6;
  };
  know(to);
  Mat3 K;
  Vec3 c;
  if (change(from.gyr, to.gyr, K, c)) {
    Eigen::Map<Mat3> M(s_.x.gyr_matrix.data());
    const Mat3 gain = (Mat3::Identity() - M) * K.inverse();
    M = Mat3::Identity() - gain;
    vec(s_.x.gyr_bias_radps) += gain * c;
    take_gyr_matrix(to.gyr);
  }
  if (change(from.acc, to.acc, K, c)) {
    const Vec3 force = kStandardGravity_mps2 * mat(s_.R_world_body).row(2).transpose() + vec(s_.x.acc_bias_mps2);
    vec(s_.x.acc_bias_mps2) += K * force + c - force;
    take_acc_bias(to.acc);
  }
  if (change(from.mag, to.mag, K, c)) {
    const Vec3 before = K * s_.hard_iron.body_uT(params_.hard_iron) + c;  // in the new readings
    std::optional<Mat3> calibrated_uT2;
    if (to.mag.status == CalibrationStatus::kOk && mat(to.mag.bias_covariance).trace() > 0.0)
      calibrated_uT2 = mat(to.mag.matrix) * mat(to.mag.bias_covariance) * mat(to.mag.matrix).transpose();
    s_.hard_iron.rebase(K, c, calibrated_uT2);
    // What was taken from the calibration is not carried any more, and it was too sure to be unlearnt by and by.
    if (from.mag.status == CalibrationStatus::kOk && to.mag.status == CalibrationStatus::kReplaced)
      s_.hard_iron.reset(params_.hard_iron);
    s_.iron_finder.rebase(K, c);
    s_.field.rescale(std::cbrt(std::abs(K.determinant())));
    s_.error.by_iron().leftCols<3>() *= K.inverse();
    s_.error.change_iron(s_.hard_iron.body_uT(params_.hard_iron) - before);
  }
}

}  // namespace stillpoint::fusion

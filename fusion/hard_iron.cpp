#include "fusion/hard_iron.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stillpoint::fusion {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
constexpr double kUnknownField_uT = 100.0;
constexpr double kFoundWithin_uT = 15.0;  ///< root of the trace, 25 deg of heading: better than none
constexpr double kSettled_uT = 3.0;       ///< root of the trace
constexpr double kUnexpected = 3.0;       ///< the mean of a chi-square of three: larger than the prior has it
constexpr double kAnother = 16.0;         ///< of a chi-square of three
constexpr double kSurprise = 16.0;        ///< of a chi-square of three
constexpr double kMisfitTime_s = 10.0;    ///< a misfit this long is a new state of affairs: learn anew

}  // namespace

void HardIron::reset(const HardIronParams& params) noexcept {
  const bool settled = settled_;
  *this = HardIron{};
  settled_ = settled;
  Eigen::Map<Matrix6> P(p_.data());
  P.topLeftCorner<3, 3>() = kUnknownField_uT * kUnknownField_uT * Mat3::Identity();
  P.bottomRightCorner<3, 3>() = params.sd_uT * params.sd_uT * Mat3::Identity();
}

Vec3 HardIron::body_uT(const HardIronParams& params) const noexcept {
  const Vec3 h = vec(body_);
  if (params.sd_uT <= 0.0) return Vec3::Zero();
  const double evidence = h.dot(body_covariance().ldlt().solve(h));
  return evidence > params.doubt ? Vec3(h * (1.0 - params.doubt / evidence)) : Vec3::Zero();
}

Mat3 HardIron::body_covariance() const noexcept {
  return Eigen::Map<const Matrix6>(p_.data()).bottomRightCorner<3, 3>();
}

Mat3 HardIron::left_uT2(const HardIronParams& params) const noexcept {
  if (params.sd_uT <= 0.0) return Mat3::Zero();
  const Vec3 left = vec(body_) - body_uT(params);
  return body_covariance() + left * left.transpose();
}

Mat3 HardIron::unseen_uT2(const HardIronParams& params) const noexcept {
  if (params.unseen_sd_uT <= params.sd_uT || params.sd_uT <= 0.0) return Mat3::Zero();
  const Eigen::SelfAdjointEigenSolver<Mat3> seen(body_covariance());
  Vec3 more;
  for (int i = 0; i < 3; ++i) {
    const double shown = std::max(0.0, 1.0 / seen.eigenvalues()(i) - 1.0 / (params.sd_uT * params.sd_uT));
    const double wide = 1.0 / (shown + 1.0 / (params.unseen_sd_uT * params.unseen_sd_uT));
    more(i) = std::max(0.0, wide - seen.eigenvalues()(i));
  }
  return seen.eigenvectors() * more.asDiagonal() * seen.eigenvectors().transpose();
}

void HardIron::observe(const HardIronParams& params, const Vec3& field_world_uT, const Mat3& R_mean,
                       double time_s) noexcept {
  if (params.sd_uT <= 0.0 || !field_world_uT.allFinite()) return;
  Eigen::Map<Matrix6> P(p_.data());
  for (int i = 0; i < 3; ++i) {
    P(i, i) += params.field_walk_uT_rtHz * params.field_walk_uT_rtHz * time_s;
    P(3 + i, 3 + i) += params.walk_uT_rtHz * params.walk_uT_rtHz * time_s;
  }
  // (A15) The unevenness of the place stays for a while: it has a power density, not a variance per reading.
  const double variance = params.noise_uT * params.noise_uT * std::max(1.0, 2.0 * params.noise_time_s / time_s);
  Eigen::Matrix<double, 3, 6> H;
  H << Mat3::Identity(), R_mean;
  const Eigen::Matrix<double, 6, 3> PHt = P * H.transpose();
  const Mat3 S = H * PHt + variance * Mat3::Identity();
  const Vec3 residual = field_world_uT - vec(place_) - R_mean * vec(body_);
  const Mat3 S_instant = S + (params.noise_uT * params.noise_uT - variance) * Mat3::Identity();
  const bool misfit = started_ && residual.dot(S_instant.inverse() * residual) > kSurprise;
  misfit_s_ = misfit ? misfit_s_ + time_s : 0.0;
  if (misfit_s_ > kMisfitTime_s) {
    reset(params);
    return;
  }
  if (misfit) return;
  const Eigen::Matrix<double, 6, 3> K = PHt * S.inverse();
  const Vector6 correction = K * residual;
  P -= K * PHt.transpose();
  P = Matrix6(0.5 * (P + P.transpose()));
  vec(place_) += correction.head<3>();
  vec(body_) += correction.tail<3>();
  started_ = true;
  settled_ |= body_covariance().trace() < kSettled_uT * kSettled_uT;
}

bool HardIron::contradicted(const HardIronParams& params, const Vec3& body_uT,
                            const Mat3& covariance_uT2) const noexcept {
  if (params.sd_uT <= 0.0 || covariance_uT2.trace() > kFoundWithin_uT * kFoundWithin_uT) return false;
  const auto apart = [](const Vec3& by_uT, const Mat3& covariance) {
    return by_uT.dot(covariance.ldlt().solve(by_uT));
  };
  // What lies within the prior this filter finds by itself, with less trust in a room that moves with the motion.
  const Mat3 expected = params.sd_uT * params.sd_uT * Mat3::Identity() + covariance_uT2;
  return apart(body_uT, expected) > kUnexpected && apart(body_uT - this->body_uT(params), covariance_uT2) > kAnother;
}

void HardIron::begin_at(const HardIronParams& params, const Vec3& body_uT, const Mat3& covariance_uT2) noexcept {
  reset(params);
  vec(body_) = body_uT;
  Eigen::Map<Matrix6>(p_.data()).bottomRightCorner<3, 3>() = covariance_uT2;
  settled_ = true;
}

void HardIron::rebase(const Mat3& K, const Vec3& c, const std::optional<Mat3>& calibrated_uT2) noexcept {
  Eigen::Map<Matrix6> P(p_.data());
  // The field of the place, seen through K at every attitude, keeps its direction and changes its size.
  const double scale = std::cbrt(std::abs(K.determinant()));
  Matrix6 change = Matrix6::Zero();
  change.topLeftCorner<3, 3>() = scale * Mat3::Identity();
  change.bottomRightCorner<3, 3>() = K;
  P = change * Matrix6(P) * change.transpose();
  vec(place_) *= scale;
  vec(body_) = K * vec(body_) + c;
  if (!calibrated_uT2 || !(calibrated_uT2->trace() < body_covariance().trace())) return;
  vec(body_).setZero();
  P.rightCols<3>().setZero();
  P.bottomRows<3>().setZero();
  P.bottomRightCorner<3, 3>() = *calibrated_uT2;
}

}  // namespace stillpoint::fusion

#include "calib_online/field_filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calib_online/directions.h"
#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kPairGate = 16.0;           // chi-square of three; beyond, a pair is set aside
constexpr double kStillLearning = 2.0;       // a misfit mostly of the states is no verdict on what was learnt
constexpr double kMemory = 0.98;             // of the misfits, a pair
constexpr double kChangeMemory = 0.9;        // of those that speak of a change
constexpr double kExplainedByCarried = 0.7;  // of the misfits' energy by one carried field: it turns with the body
constexpr std::uint32_t kRunToChange = 6;    // pairs set aside lately
constexpr std::uint32_t kLeastPairs = 30;    // before anything is said to be better than the factory calibration
constexpr double kKnown = 0.02;  // of the field, where it is known worst: 1.1 deg of heading; or of what is carried
constexpr double kBetter = 0.1;  // of the factory's mean square misfit; what is left is the world's and may be in D too

}  // namespace

void FieldFilter::reset() noexcept {
  s_ = State{};
  StateMat P = StateMat::Zero();
  P.diagonal().head<9>().setConstant(squared(params_.soft_iron_sd));
  // (F3) The strength of the field is not known, so neither is a common scale of all readings: trace(D) stays zero.
  Eigen::Matrix<double, 9, 1> scale = Eigen::Matrix<double, 9, 1>::Zero();
  scale[0] = scale[4] = scale[8] = 1.0 / std::sqrt(3.0);
  P.topLeftCorner<9, 9>() -= squared(params_.soft_iron_sd) * scale * scale.transpose();
  P.diagonal().tail<3>().setConstant(squared(params_.hard_iron_sd_uT));
  s_.P.set(P);
  s_.misfit_uT2 = squared(params_.place_uT);
}

void FieldFilter::predict(double dt_s) noexcept {
  if (!(dt_s > 0.0)) return;
  StateMat P = s_.P.full();
  P.diagonal().tail<3>().array() = (P.diagonal().tail<3>().array() + squared(params_.hard_iron_walk_uT_rts) * dt_s)
                                       .min(squared(params_.hard_iron_sd_uT));
  s_.P.set(P);
}

/// (F2) R ((I + D) after - c) - ((I + D) before - c) = noise, of the elements of D and of c.
FieldFilter::Mat3x12 FieldFilter::design(const Pair& pair, const Mat3& lever) noexcept {
  Mat3x12 h;
  for (int j = 0; j < 3; ++j) h.block<3, 3>(0, 3 * j) = pair.R.col(j) * pair.after_uT.transpose();
  for (int i = 0; i < 3; ++i) h.block<1, 3>(i, 3 * i) -= pair.before_uT.transpose();
  h.rightCols<3>() = lever;
  return h;
}

/// The body carries another field, and the misfits have shown which: from there it is as open as at the start. The
/// matrix stays. A sensor of which nothing was known yet carries what its maker did not take out: no change of it.
void FieldFilter::open_carried_field(const Vec3& change) noexcept {
  if (observable()) ++s_.changes;
  Eigen::Map<StateVec>(s_.x.data()).tail<3>() += change;
  StateMat open = s_.P.full();
  open.diagonal().tail<3>().array() += squared(params_.hard_iron_sd_uT);
  s_.P.set(open);
  s_.change_information = {};
  s_.change_rhs = {};
  s_.change_energy = 0.0;
  s_.rejected_run = 0;
  s_.factory_error = s_.learnt_error = 0.0;
  s_.pairs = s_.compared = 0;
}

/// The calibrated field after the turn, in axes of before it.
Vec3 FieldFilter::field_of(const Pair& pair) const noexcept {
  return pair.R * (matrix() * pair.after_uT - carried_uT());
}

/// What the gyroscope's error makes of the pair: across the field a wrong turn moves it, along it never.
Mat3 FieldFilter::turned(const Pair& pair, const Vec3& field) const noexcept {
  const double rate_sd = pair.gyr_bias_sd_radps > 0.0 ? std::min(params_.gyr_bias_sd_radps, pair.gyr_bias_sd_radps)
                                                      : params_.gyr_bias_sd_radps;
  const double matrix_sd = std::min(params_.gyr_matrix_sd, pair.gyr_matrix_sd);
  const double turn_var = squared(matrix_sd * pair.path_rad) + squared(rate_sd * pair.time_s);
  return turn_var * skew(field) * skew(field).transpose();
}

double FieldFilter::misfit_uT2(const Pair& pair) const noexcept {
  const Vec3 field = field_of(pair), left = matrix() * pair.before_uT - carried_uT() - field;
  return std::max(0.0, left.squaredNorm() - turned(pair, field).trace());
}

void FieldFilter::compare_with_factory(double factory_uT2, double learnt_uT2) noexcept {
  s_.factory_error = kMemory * s_.factory_error + factory_uT2;
  s_.learnt_error = kMemory * s_.learnt_error + learnt_uT2;
  ++s_.compared;
}

FieldFilter::Verdict FieldFilter::update(const Pair& pair) noexcept {
  const Vec3 z = pair.before_uT - pair.R * pair.after_uT;
  const Mat3 lever = Mat3::Identity() - pair.R;  // of c
  const Mat3x12 h = design(pair, lever);
  Eigen::Map<StateVec> x(s_.x.data());
  const StateMat P = s_.P.full();
  const Vec3 e = z - h * x;
  const Vec3 field = field_of(pair);
  const Mat3 turned = this->turned(pair, field);
  s_.white_uT2 += std::max(1.0 - kMemory, 1.0 / (s_.pairs + 1.0)) * (pair.noise_uT2 - s_.white_uT2);
  const double own = std::max(s_.misfit_uT2, s_.white_uT2);
  const Eigen::Matrix<double, kStates, 3> Ph = P * h.transpose();
  const Mat3 S = h * Ph + own * Mat3::Identity() + turned;
  const Mat3 S_inv = S.inverse();
  if (!S_inv.allFinite() || !e.allFinite()) return Verdict::kWorldChanged;
  // A place as uneven as was assumed at first is no change, however even it was until now.
  const Mat3 S_first = S + std::max(0.0, squared(params_.place_uT) - own) * Mat3::Identity();
  const bool rejected = e.dot(S_first.inverse() * e) > kPairGate;
  const double limit = kPairGate * S_first.trace() / 3.0;  // one gross misfit must not make the next ones look small
  const double misfit = std::min(e.squaredNorm(), limit);
  const Mat3 known = h * Ph;
  if (known.trace() < kStillLearning * (S_first - known).trace())
    compare_with_factory(rejected ? misfit : z.squaredNorm(), misfit);
  // (F5) The share of a misfit that is the pair's own and not that of the states.
  s_.misfit_uT2 += (1.0 - kMemory) * (misfit * own / S.trace() - s_.misfit_uT2);
  note_misfit(e, lever, rejected);
  if (rejected) {
    const std::optional<Vec3> change = change_of_body();
    if (!change) return Verdict::kWorldChanged;
    open_carried_field(*change);
    return Verdict::kBodyChanged;
  }
  // (F4) Noise averages out over pairs. The place does not: a hand comes back to the same spots in the same attitudes.
  // Nor does the gyroscope: its matrix is wrong in the same way in every turn.
  const Mat3 repeated = (params_.repeats - 1.0) * ((own - s_.white_uT2) * Mat3::Identity() + turned);
  const double surprise = std::max(1.0, e.dot(S_inv * e) / kPairGate);
  const Eigen::Matrix<double, kStates, 3> gain = Ph * Mat3(surprise * S + repeated).inverse();
  x += gain * e;
  StateMat next = P - gain * Ph.transpose();
  next = (0.5 * (next + next.transpose())).eval();
  next.diagonal() = next.diagonal().cwiseMax(1e-14);
  s_.P.set(next);
  s_.strength_uT += std::max(1.0 - kMemory, 1.0 / (s_.pairs + 1.0)) * (field.norm() - s_.strength_uT);
  ++s_.pairs;
  return Verdict::kUsed;
}

/// (F6) A change dc of the carried field leaves e = (I - R) dc in every pair from now on; one of the world leaves its
/// mark on the one pair that it happened in, or a different one on each.
void FieldFilter::note_misfit(const Vec3& e, const Mat3& lever, bool rejected) noexcept {
  for (double& v : s_.change_information) v *= kChangeMemory;
  for (double& v : s_.change_rhs) v *= kChangeMemory;
  mat(s_.change_information) += lever.transpose() * lever;
  vec(s_.change_rhs) += lever.transpose() * e;
  s_.change_energy = kChangeMemory * s_.change_energy + e.squaredNorm();
  if (rejected)
    ++s_.rejected_run;
  else if (s_.rejected_run > 0)
    --s_.rejected_run;
}

std::optional<Vec3> FieldFilter::change_of_body() const noexcept {
  if (s_.rejected_run < kRunToChange) return std::nullopt;
  const Mat3 N = mat(s_.change_information) + 0.05 * Mat3::Identity();
  const Vec3 change = N.ldlt().solve(vec(s_.change_rhs));
  if (change.dot(vec(s_.change_rhs)) > kExplainedByCarried * s_.change_energy) return change;
  return std::nullopt;
}

Mat3 FieldFilter::matrix() const noexcept { return Mat3::Identity() + Eigen::Map<const RowMajor3>(s_.x.data()); }
Vec3 FieldFilter::carried_uT() const noexcept { return Eigen::Map<const StateVec>(s_.x.data()).tail<3>(); }
Mat3 FieldFilter::carried_covariance() const noexcept { return s_.P.full().bottomRightCorner<3, 3>(); }

FieldFilter::Uncertainty FieldFilter::uncertainty() const noexcept {
  const StateMat P = s_.P.full();
  Uncertainty out;
  constexpr int kDirections = 32;
  for (int k = 0; k < kDirections; ++k) {
    const Vec3 u = even_direction(k, kDirections);
    Mat3x12 g = Mat3x12::Zero();
    for (int i = 0; i < 3; ++i) g.block<1, 3>(i, 3 * i) = s_.strength_uT * u.transpose();
    g.rightCols<3>() = -Mat3::Identity();
    const Mat3 C = g * P * g.transpose();
    out.mean_uT2 += C.trace() / (3.0 * kDirections);
    out.worst_uT2 = std::max(out.worst_uT2, C.trace() / 3.0);
    out.norm_uT2 += u.dot(C * u) / kDirections;
  }
  return out;
}

bool FieldFilter::better_than_factory() const noexcept {
  return s_.compared >= kLeastPairs && s_.learnt_error < kBetter * s_.factory_error;
}

bool FieldFilter::observable() const noexcept {
  return s_.pairs > 0 && uncertainty().worst_uT2 < squared(kKnown * std::max(s_.strength_uT, carried_uT().norm()));
}

}  // namespace stillpoint::calib

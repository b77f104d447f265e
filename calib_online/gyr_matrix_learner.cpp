#include "calib_online/gyr_matrix_learner.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kTurnGate = 25.0;          // chi-square of three; beyond, a turn is refused
constexpr double kLongestTurn_rad = 15.0;   // beyond, what is not in the matrix outweighs it
constexpr double kTellsOfMatrix_rad = 0.2;  // smaller turns say nothing of the matrix
constexpr double kDirectionFloor = 0.002;   // rad, of a window's direction
constexpr double kFactoryDirection = 0.03;  // rad, before the accelerometer is learnt
constexpr double kMostCorrected_rad = 0.2;  // by a bias that became known on the way; beyond, it is no small angle
constexpr double kRivalTimes = 10.0;        // of the prior's sd: a wrong range, another sensor
constexpr double kBeyond = 28.0;            // chi-square of nine: one in a thousand
constexpr double kPoor_rad = 0.012;         // of a turn, beside what the matrix does to it
constexpr double kLatelyAtFirst =
    100.0;                             // of another sensor: ten times the sd, until its turns have shown how they fit
constexpr double kLatelyShare = 0.15;  // of a turn
constexpr double kWhileRefused = 2.0;  // nats for the rival, for the stated deviation
constexpr double kLeastTurnNoise = 0.01;  // of the assumed variance
constexpr double kScaleDoubted = 9.0;     // chi-square of a known turn, by the factory's scales
constexpr double kExplained = 0.25;       // of that, by wide ones: the prior is what contradicts
constexpr int kRounds = 4;                // an axis is by the matrix: after three its change is below 1e-4
constexpr std::uint32_t kTurnsNeeded = 4;
constexpr std::uint32_t kTurnsRefusedToOpen = 2;  // in a row

}  // namespace

/// What one turn says of the matrix, from the one at which it was integrated.
struct GyrMatrixLearner::Turn {
  Vec3 u_before, u_after;
  Mat3 R;  ///< v_before = R v_after
  Mat39 J;
  Mat3 H_used, rotation_cov;
  double direction_var = 0.0;
  double noise_scale = 1.0;
  double bias_var = 0.0;  ///< rad^2, what the bias leaves of the way

  /// As it looks from another matrix: scales a third off turn a chord into another than its arc. Half the square of
  /// what that matrix leaves open is what a linear measurement of it cannot say.
  [[nodiscard]] Turn from(const GyroMatrixFit& fit) const noexcept {
    Turn out = *this;
    out.R = R * exp_quat(Vec3(J * (rows_of(fit.H) - rows_of(H_used)))).toRotationMatrix();
    out.H_used = fit.H;
    out.rotation_cov += squared(0.5 * (J * fit.covariance * J.transpose()).trace()) * Mat3::Identity();
    return out;
  }
  [[nodiscard]] Fit by(const GyroMatrixFit& fit) const noexcept {
    const Turn turn = from(fit);
    const Vec3 predicted = turn.R.transpose() * u_before;
    const Mat3 lever = skew(predicted);
    const Mat39 M = lever * J;
    const Vec3 e = u_after - predicted;
    const Mat3 S = M * fit.covariance * M.transpose() + 2.0 * direction_var * Mat3::Identity() +
                   lever * turn.rotation_cov * lever.transpose();
    return {e.dot(S.inverse() * e), std::log(std::max(1e-300, S.determinant())), S.trace() / 3.0};
  }
  void add_to(GyroMatrixSums& sums, const GyroMatrixFit& fit) const noexcept {
    const Turn turn = from(fit);
    sums.add_direction(u_before, u_after, turn.R, J, turn.H_used, direction_var, turn.rotation_cov);
  }
};

GyrMatrixLearner::GyrMatrixLearner(const GyroMatrixParams& params, const TriadCalibration& factory,
                                   double bias_prior_sd_radps, double gravity_mps2)
    : params_(params), factory_(factory), bias_prior_sd_radps_(bias_prior_sd_radps), gravity_mps2_(gravity_mps2) {}

void GyrMatrixLearner::restore(const State& s) noexcept {
  s_ = s;
  rivalry_.restore(s.rivalry);
  s_.has_previous = 0;  // where the body was before the restart says nothing of a turn since
}

GyroMatrixFit GyrMatrixLearner::fit(const GyroMatrixSums& sums, MatrixPrior prior) const noexcept {
  const double scale_times = prior == MatrixPrior::kFactory ? 1.0 : kRivalTimes;
  const double cross_times = prior == MatrixPrior::kWide ? kRivalTimes : 1.0;
  return solve(sums, mat(factory_.matrix), scale_times * params_.scale_sd, cross_times * params_.cross_sd);
}

GyroMatrixFit GyrMatrixLearner::published() const noexcept {
  return fit(s_.published, static_cast<MatrixPrior>(s_.wide));
}

/// No sensor of these axes: one of them is mirrored, or two are exchanged.
bool GyrMatrixLearner::beyond_wide(const GyroMatrixFit& fit) const noexcept {
  const Mat3 off = (fit.H - mat(factory_.matrix)) / kRivalTimes;
  const double scales = off.diagonal().squaredNorm();
  return scales / squared(params_.scale_sd) + (off.squaredNorm() - scales) / squared(params_.cross_sd) > kBeyond;
}

bool GyrMatrixLearner::absorb(const Window& w, const CalibrationSnapshot& used, double pushed_var) noexcept {
  if ((w.has & kAcc) == 0 || w.refusal == Refusal::kNotGravity) return false;
  Turn turn;
  turn.u_after = used.acc.apply(w.acc_mps2, w.temp_degC).normalized();
  turn.u_before = used.acc.apply(s_.previous_acc_mps2, s_.previous_temp_degC).normalized();
  const bool had = s_.has_previous != 0;
  s_.previous_acc_mps2 = w.acc_mps2;
  s_.previous_temp_degC = w.temp_degC;
  s_.has_previous = turn.u_after.allFinite() ? 1 : 0;
  if (!had || !turn.u_after.allFinite() || !turn.u_before.allFinite() || !w.rotation_valid) return false;
  if (w.rotation_path_rad < kTellsOfMatrix_rad || w.rotation_path_rad > kLongestTurn_rad) return false;
  const double known = used.acc.norm_sd > 0.0 ? used.acc.norm_sd / gravity_mps2_ : kFactoryDirection;
  turn.noise_scale = s_.noise.variance_scale(kLeastTurnNoise);
  turn.direction_var = squared(known) + pushed_var + turn.noise_scale * squared(kDirectionFloor);
  // The way was integrated with the bias that was known then.
  const Mat3 J_bias = mat(w.d_rotation_d_bias);
  const Vec3 late = J_bias * (used.gyr.bias_at(w.temp_degC) - vec(w.gyr_bias_used));
  if (!(late.norm() < kMostCorrected_rad)) return false;
  const Quat q(w.q_previous_this[0], w.q_previous_this[1], w.q_previous_this[2], w.q_previous_this[3]);
  turn.R = (q * exp_quat(late)).toRotationMatrix();
  const Mat3 bias_cov = used.gyr.bias_covariance[0] > 0.0 ? Mat3(mat(used.gyr.bias_covariance))
                                                          : Mat3(squared(bias_prior_sd_radps_) * Mat3::Identity());
  const Mat3 of_bias = J_bias * bias_cov * J_bias.transpose();
  turn.bias_var = of_bias.trace() / 3.0;
  turn.rotation_cov =
      of_bias + turn.noise_scale *
                    (squared(kGyroWhite_radps_rtHz) * w.rotation_s + squared(kGyroNonlinearity * w.rotation_path_rad)) *
                    Mat3::Identity();
  turn.J = Eigen::Map<const Mat39>(w.d_rotation_d_matrix.data());
  turn.H_used = mat(w.gyr_matrix_used);
  learn(turn);
  return true;
}

/// Every turn speaks; about which axis is what a turn about another does not repeat.
void GyrMatrixLearner::learn(const Turn& turn) noexcept {
  const Fit by_published = turn.by(published());
  const bool refused = by_published.chi2 > kTurnGate;
  s_.in_a_row = refused ? s_.in_a_row + 1 : 0;
  const Vec3 axis = turn.R.transpose() * turn.u_before;
  // Neither bias nor directions are known well enough for a verdict.
  const bool poor = turn.bias_var + turn.direction_var > squared(kPoor_rad);
  // A fit that is refused shows at once, by no more than another sensor does; one that is good again by and by.
  const double fits = std::min(by_published.chi2 / 3.0, kLatelyAtFirst);
  if (!poor) s_.lately = refused ? std::max(s_.lately, fits) : s_.lately + kLatelyShare * (fits - s_.lately);
  if (!poor && !refused) s_.noise.see(by_published.chi2 * turn.noise_scale, 3.0);
  if (poor) {
    if (!refused) turn.add_to(s_.published, published());
    if (rivalry_.is_open()) turn.add_to(s_.rival, fit(s_.rival, MatrixPrior::kWide));
    return;
  }
  if (rivalry_.is_open()) {
    rivalry_.add_vote(Rivalry::vote(by_published, turn.by(fit(s_.rival, MatrixPrior::kWide))), axis);
    if (rivalry_.verdict(kTurnsNeeded) == Rivalry::Verdict::kPublishedStays) rivalry_.close();
  } else if (refused && s_.in_a_row >= kTurnsRefusedToOpen) {
    s_.rival = {};
    rivalry_.open(axis);
  }
  if (refused)
    ++s_.refused;
  else
    turn.add_to(s_.published, published());
  if (rivalry_.is_open()) turn.add_to(s_.rival, fit(s_.rival, MatrixPrior::kWide));
  if (rivalry_.verdict(kTurnsNeeded) == Rivalry::Verdict::kRivalWins &&
      !beyond_wide(fit(s_.rival, MatrixPrior::kWide))) {
    s_.published = s_.rival;
    s_.lately = 1.0;
    s_.wide = static_cast<std::uint32_t>(MatrixPrior::kWide);
    rivalry_.close();
  }
  s_.rivalry = rivalry_.state();
}

void GyrMatrixLearner::sensor_replaced() noexcept {
  s_.lately = std::max(s_.lately, kLatelyAtFirst);
  // So little the turns before count, whatever they agreed in: a sensor that is the same has them confirmed by a few.
  s_.published.forget(s_.noise.variance_scale(kLeastTurnNoise) / kLatelyAtFirst);
  if (rivalry_.is_open()) return;
  s_.rival = {};
  rivalry_.open(Vec3::UnitZ());
  s_.rivalry = rivalry_.state();
}

/// Whether there is a known turn that only the factory's scales contradict: not what else is known, not other turns.
bool GyrMatrixLearner::scales_doubted(std::span<const KnownTurn> turns) const noexcept {
  if (static_cast<MatrixPrior>(s_.wide) != MatrixPrior::kFactory) return false;
  GyroMatrixSums sums = s_.published;
  for (const KnownTurn& turn : turns)
    if (const GyroMatrixFit now = fit(sums, MatrixPrior::kFactory);
        seen_by(now, turn).chi2(turn.angle_rad) < kScaleDoubted)
      add_known_turn(now, turn, sums);
  const GyroMatrixFit narrow = fit(sums, MatrixPrior::kFactory), wide = fit(sums, MatrixPrior::kWideScale);
  return std::any_of(turns.begin(), turns.end(), [&](const KnownTurn& turn) {
    const double chi2 = seen_by(narrow, turn).chi2(turn.angle_rad);
    return chi2 > kScaleDoubted && seen_by(wide, turn).chi2(turn.angle_rad) < kExplained * chi2;
  });
}

/// The turn that fits best, of those that are not used and not refused: so the odd one out is the last, whatever the
/// order in which they were stated.
KnownTurn* GyrMatrixLearner::best_fit(std::span<KnownTurn> turns) const noexcept {
  const GyroMatrixFit now = published();
  KnownTurn* best = nullptr;
  double least = kTurnGate;
  for (KnownTurn& turn : turns)
    if (const double chi2 = seen_by(now, turn).chi2(turn.angle_rad); !turn.used && chi2 < least)
      best = &turn, least = chi2;
  return best;
}

bool GyrMatrixLearner::absorb(std::span<KnownTurn> turns) noexcept {
  if (scales_doubted(turns)) {  // what turns said before was linearised about those scales
    rivalry_.close();
    s_ = {};
    s_.wide = static_cast<std::uint32_t>(MatrixPrior::kWideScale);
  }
  const GyroMatrixSums before = s_.published;
  for (KnownTurn& turn : turns) {
    turn.used = false;
    if (rivalry_.is_open()) add_known_turn(fit(s_.rival, MatrixPrior::kWide), turn, s_.rival);
  }
  while (KnownTurn* const next = best_fit(turns)) {
    next->used = true;
    add_known_turn(published(), *next, s_.published);
  }
  for (int round = 1; round < kRounds; ++round) {
    const GyroMatrixFit now = published();
    s_.published = before;
    for (const KnownTurn& turn : turns)
      if (turn.used) add_known_turn(now, turn, s_.published);
  }
  return s_.published.segments > before.segments;
}

bool GyrMatrixLearner::publish(TriadCalibration& gyr) noexcept {
  GyroMatrixFit now = published();
  if (now.status != FitStatus::kOk) return false;
  now.covariance *= std::max(1.0, s_.lately);
  if (const double weight = rivalry_.weight(s_.in_a_row > 0 ? kWhileRefused : 0.0); weight > 0.0) {
    const GyroMatrixFit rival = fit(s_.rival, MatrixPrior::kWide);
    const Vec9 apart = rows_of(rival.H) - rows_of(now.H);
    now.covariance += weight * (rival.covariance + apart * apart.transpose());
  }
  if (s_.published.segments == 0) now.H = mat(factory_.matrix);
  stated_ = now;
  gyr.matrix = array(now.H);
  Eigen::Map<Vec9>(gyr.matrix_sd.data()) = now.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return true;
}

}  // namespace stillpoint::calib

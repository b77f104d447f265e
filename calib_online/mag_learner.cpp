#include "calib_online/mag_learner.h"
#include "core/units.h"

#include <Eigen/Dense>
#include <cmath>

namespace stillpoint::calib {
namespace {

constexpr std::int64_t kPublish_ns = 5'000'000'000;  // readers of the calibration need no more than that
constexpr std::uint32_t kFewTurns = 30;
constexpr std::size_t kEnoughForAMisfit = 12;  // three of each, of which twelve are spent on what is learnt

}  // namespace

void MagLearner::restore(const State& s) noexcept {
  field_.restore(s.field);
  t_ns_ = s.t_ns;
  published_ns_ = s.published_ns;
}

FieldFilter::Pair MagLearner::pair_of(const FieldTurn& t, double gyr_matrix_sd,
                                      double gyr_bias_sd_radps) const noexcept {
  const Quat q(t.q_before_after[0], t.q_before_after[1], t.q_before_after[2], t.q_before_after[3]);
  return {.before_uT = factory_.apply(t.before_uT, t.temp_degC),
          .after_uT = factory_.apply(t.after_uT, t.temp_degC),
          .R = q.toRotationMatrix(),
          .noise_uT2 = t.noise_uT2,
          .path_rad = t.path_rad,
          .time_s = t.time_s,
          .gyr_matrix_sd = gyr_matrix_sd,
          .gyr_bias_sd_radps = gyr_bias_sd_radps};
}

bool MagLearner::absorb(const FieldTurn& t, double gyr_matrix_sd, double gyr_bias_sd_radps) noexcept {
  const bool follows = t_ns_ > 0 && t.t_end_ns > t_ns_;
  if (follows) field_.predict(in_seconds(t.t_end_ns - t_ns_));
  t_ns_ = t.t_end_ns;
  const auto verdict = field_.update(pair_of(t, gyr_matrix_sd, gyr_bias_sd_radps));
  const bool due = !follows || t.t_end_ns - published_ns_ >= kPublish_ns;
  if (!due && verdict != FieldFilter::Verdict::kBodyChanged) return false;
  published_ns_ = t.t_end_ns;
  return true;
}

std::optional<double> MagLearner::misfit_uT2(std::span<const FieldTurn> turns, double gyr_matrix_sd,
                                             double gyr_bias_sd_radps) const noexcept {
  if (turns.size() < kEnoughForAMisfit) return std::nullopt;
  double sum = 0.0;
  for (const FieldTurn& t : turns) sum += field_.misfit_uT2(pair_of(t, gyr_matrix_sd, gyr_bias_sd_radps));
  return sum / (3.0 * static_cast<double>(turns.size()) - FieldFilter::kStates);
}

/// The frame is the gyroscope's, which the turns between windows have brought into the accelerometer's.
std::optional<TriadCalibration> MagLearner::so_far() const noexcept {
  TriadCalibration out = factory_;
  out.windows = field_.state().pairs;
  const Mat3 T = field_.matrix();
  const Mat3 H_inv = mat(factory_.matrix).inverse();
  const Mat3 to_reading = H_inv * T.inverse();
  if (!to_reading.allFinite() || !(T.determinant() > 0.0)) return std::nullopt;
  // u = T (H_f (y - b_f)) - c
  out.matrix = array(Mat3(T * mat(factory_.matrix)));
  out.bias = array(Vec3(vec(factory_.bias) + to_reading * field_.carried_uT()));
  out.bias_covariance = array(Mat3(to_reading * field_.carried_covariance() * to_reading.transpose()));
  out.norm_sd = std::sqrt(field_.uncertainty().norm_uT2);
  out.status = CalibrationStatus::kOk;
  return out;
}

void MagLearner::publish(TriadCalibration& out) const noexcept {
  const FieldFilter::State& f = field_.state();
  // Half known is not published: what turns about one axis leave open, the place would fill in.
  const bool observable = field_.observable(), better = field_.better_than_factory();
  const auto learnt = observable && better ? so_far() : std::nullopt;
  if (learnt) {
    out = *learnt;
    return;
  }
  out = factory_;
  out.windows = f.pairs;
  out.status = observable && better  ? CalibrationStatus::kNotPositiveDefinite
               : f.changes > 0       ? CalibrationStatus::kReplaced
               : f.pairs < kFewTurns ? CalibrationStatus::kTooFewWindows
               : observable          ? CalibrationStatus::kFactory
                                     : CalibrationStatus::kNotObservable;
}

}  // namespace stillpoint::calib

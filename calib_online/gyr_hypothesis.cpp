#include "calib_online/gyr_hypothesis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kStretch_s = 900.0;                   // longer, and the bias may have wandered inside it
constexpr double kStretchTemp_K = 4.0;                 // beyond, one mean says too little of the slope
constexpr double kAnotherAttitude = 0.985;             // cosine of 10 degrees
constexpr double kSingle_radps = 0.1 * kRadPerDeg;     // a stretch of one window may be no rest at all; fades as 1/n
constexpr double kLeastGyrNoise = 0.01;                // of the assumed variance
constexpr double kMostlyGyrNoise = 0.5;                // of an error: what is known is the smaller part
constexpr double kGyrHuber_sd = 2.0;                   // sd; beyond, a window counts less
constexpr double kFreeTurn_radps = 30.0 * kRadPerDeg;  // any turn about an axis that neither gravity nor field shows
constexpr double kUnseen = 4.0;                        // times the variance of a turn about the others: such an axis

double log_determinant(const Mat3& S) { return std::log(std::max(1e-300, S.determinant())); }

}  // namespace

void Stretch::add(const RestRate& r) noexcept {
  if (windows == 0) {
    start_ns = r.t_ns;
    temp_degC = r.temp_degC;
    turn_covariance = array(r.turn_covariance);
    up = array(r.up_body);
    direction_sd = r.direction_sd;
    rate = {};
    rounding_var = {};
    covariance = {};
    tau = tau2 = 0.0;
  }
  const double n = ++windows;
  // Huber, against the stretch so far: one pushed window must not carry a mean of many.
  const double surprise =
      n > 1 ? (r.rate_radps - vec(rate)).norm() / std::sqrt(r.covariance.trace() + squared(kSingle_radps / n)) : 0.0;
  vec(rate) += (r.rate_radps - vec(rate)) / (n * std::max(1.0, surprise / kGyrHuber_sd));
  mat(covariance) += (r.covariance - mat(covariance)) / n;
  vec(rounding_var) += (r.rounding_var - vec(rounding_var)) / n;
  tau += (r.tau - tau) / n;
  tau2 += (r.tau * r.tau - tau2) / n;
  if (r.turn_covariance.trace() < mat(turn_covariance).trace()) turn_covariance = array(r.turn_covariance);
}

bool Stretch::same_attitude(const RestRate& r) const noexcept { return vec(up).dot(r.up_body) > kAnotherAttitude; }

Vec3 Stretch::unseen_axis() const noexcept {
  const Eigen::SelfAdjointEigenSolver<Mat3> turn(mat(turn_covariance));
  return turn.eigenvalues()[2] > kUnseen * turn.eigenvalues()[1] ? Vec3(turn.eigenvectors().col(2)) : Vec3::Zero();
}

Mat3 Stretch::mean_covariance(double noise_scale) const noexcept {
  const double n = std::max(1U, windows);
  Mat3 out = mat(covariance) / n + noise_scale * squared(kSingle_radps / n) * Mat3::Identity();
  out.diagonal() += vec(rounding_var);
  return out;
}

Mat3 Stretch::turn(double noise_scale) const noexcept {
  const Eigen::SelfAdjointEigenSolver<Mat3> turn(mat(turn_covariance));
  Vec3 scale = Vec3::Constant(noise_scale);
  if (turn.eigenvalues()[2] > kUnseen * turn.eigenvalues()[1]) scale[2] = 1.0;
  const Vec3 variance = turn.eigenvalues().cwiseProduct(scale);
  return turn.eigenvectors() * variance.asDiagonal() * turn.eigenvectors().transpose();
}

void GyrHypothesis::predict(double dt_s) noexcept {
  if (stretch_.windows == 0) filter_.predict(dt_s);
}

void GyrHypothesis::restore(const State& s) noexcept {
  filter_.restore(s.filter);
  stretch_ = Stretch{};
  windows_ = s.windows;
  noise_ = s.noise;
}

double GyrHypothesis::noise_scale() const noexcept { return noise_.variance_scale(kLeastGyrNoise); }

void GyrHypothesis::separate(const RestRate& r, bool moved) noexcept {
  const bool another = moved || (stretch_.windows > 0 && !stretch_.same_attitude(r));
  const double age_s = in_seconds(r.t_ns - stretch_.start_ns);
  const bool long_since = age_s > kStretch_s || std::abs(r.temp_degC - stretch_.temp_degC) > kStretchTemp_K;
  if (stretch_.windows > 0 && (another || long_since)) {
    commit();
    filter_.predict(age_s);
    ++stretch_.of_attitude;
  }
  if (another) stretch_.of_attitude = 0;
}

Fit GyrHypothesis::fit(const RestRate& r) const noexcept {
  const GyrFilter present = now();
  const double tau2 = r.tau * r.tau;
  const Vec3 e = r.rate_radps - present.at(r.tau, tau2);
  Mat3 S = present.covariance_at(r.tau, tau2) + r.covariance + r.turn_covariance +
           squared(3.0 * params_.mean_floor_radps) * Mat3::Identity();
  S.diagonal() += r.rounding_var;
  return {e.dot(S.inverse() * e), log_determinant(S), S.trace() / 3.0};
}

StretchError GyrHypothesis::error_of_stretch(const Stretch& s) const noexcept {
  StretchError out;
  out.value = vec(s.rate) - filter_.at(s.tau, s.tau2);
  out.covariance = filter_.covariance_at(s.tau, s.tau2) + s.mean_covariance(noise_scale()) + s.turn(noise_scale()) +
                   squared(params_.mean_floor_radps) * Mat3::Identity();
  out.known = out.covariance.trace() / 3.0;
  // Constant in the world, and so no matter of the sensor.
  const Vec3 unseen = s.unseen_axis();
  out.covariance += squared(kFreeTurn_radps) * unseen * unseen.transpose() +
                    squared(s.direction_sd * out.value.dot(unseen)) * Mat3::Identity();
  return out;
}

Fit GyrHypothesis::fit_of_stretch(const Stretch& s) const noexcept {
  const StretchError e = error_of_stretch(s);
  return {e.value.dot(e.covariance.inverse() * e.value), log_determinant(e.covariance), e.known};
}

bool GyrHypothesis::see(const Stretch& attitude, double gate) noexcept {
  const Fit fit = fit_of_stretch(attitude);
  const double known = filter_.covariance_at(attitude.tau, attitude.tau2).trace() / 3.0;
  if (known > kMostlyGyrNoise * fit.variance || fit.chi2 > gate) return false;
  noise_.see(fit.chi2 * noise_scale(), attitude.unseen_axis().isZero() ? 3.0 : 2.0);
  return true;
}

std::uint32_t GyrHypothesis::discard_stretch() noexcept {
  const std::uint32_t discarded = stretch_.windows;
  windows_ -= discarded;
  stretch_ = Stretch{};
  return discarded;
}

/// A rate that surprises in a direction where a turn could hide is taken for half a turn, so that no turn is learnt
/// beyond 2 sd. Later stretches of the same attitude share that turn.
GyrFilter GyrHypothesis::now() const noexcept {
  GyrFilter out = filter_;
  const Stretch& s = stretch_;
  if (s.windows == 0) return out;
  if (s.of_attitude == 0) {
    const Mat3 turn = s.turn(noise_scale());
    const double largest = turn.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
    const Vec3 surprise = vec(s.rate) - filter_.at(s.tau, s.tau2);
    const Vec3 hidden = largest > 0 ? Vec3(turn * surprise / largest) : Vec3(Vec3::Zero());
    // What is taken for the vertical is off by the accelerometer's error, and so is the turn about it.
    out.begin_attitude(turn + 0.25 * hidden * hidden.transpose() +
                       squared(s.direction_sd) * hidden.squaredNorm() * Mat3::Identity());
  }
  out.update(vec(s.rate), s.mean_covariance(noise_scale()), s.tau, s.tau2);
  return out;
}

void GyrHypothesis::commit() noexcept {
  if (stretch_.windows == 0) return;
  filter_ = now();
  stretch_.windows = 0;
}

}  // namespace stillpoint::calib

#include "calib_online/gyr_learner.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace stillpoint::calib {
namespace {

constexpr double kRestGate = 48.0;  // chi-square of three: 4 sd an axis; beyond, a window is refused
constexpr double kRivalBias_radps = 10.0 * kRadPerDeg;  // half of what data sheets allow
constexpr std::uint32_t kAttitudesNeeded = 3;
constexpr std::uint32_t kWindowsAsAttitude = 8;  // where gravity and field exclude a turn, time is evidence too
constexpr double kTurnExcluded_radps = 0.04 * kRadPerDeg;
constexpr std::uint32_t kRestsRefusedToOpen = 2;  // in a row: a single window may have been pushed
constexpr double kOff = 30.0;                     // chi-square of three over many attitudes: 1e-6 by chance
constexpr double kNotOff = 3.0;                   // the same: what chance makes of it
constexpr double kDriftShare = 0.25;              // of one attitude in the mean of what they are off
constexpr double kOneSided = 0.5;                 // of the mean square, the squared mean: by chance 0.14
constexpr double kResidualMemory = 0.5;
constexpr double kContradicted = 16.0;  // chi-square of three: the rates of lately
constexpr double kChangedAtAll = 0.15;  // probability that a rate which surprises is another bias and not a turn
constexpr double kOneAttitude_radps = 0.35 * kRadPerDeg;  // a turn that hides in the only attitude that was ever seen
constexpr std::uint32_t kRefusedAtFirst = 2;  // nothing is learnt yet: so many, and the prior was too narrow
constexpr double kKnownAgain = 0.25;          // of the prior's sd: a replaced sensor's bias is known again

}  // namespace

void SeenTemperatures::see(double temp_degC) noexcept {
  min_degC = known != 0 ? std::min(min_degC, temp_degC) : temp_degC;
  max_degC = known != 0 ? std::max(max_degC, temp_degC) : temp_degC;
  known = 1;
}

GyrLearner::GyrLearner(const GyrFilterParams& params, const TriadCalibration& factory)
    : params_(params), factory_(factory), published_(params), rival_(params) {}

double GyrLearner::tau(double temp_degC) const noexcept { return (temp_degC - factory_.temp_ref_degC) / kTempScale_K; }

GyrLearner::State GyrLearner::state() const noexcept {
  // A restart ends the present attitude: what its lattice hides is told by the filter until there is another.
  GyrHypothesis::State published = published_.state();
  GyrFilter filter(params_);
  filter.restore(published.filter);
  filter.open_bias(std::sqrt(vec(attitude_.rounding_var).mean()));
  published.filter = filter.state();
  return {published, rival_.state(), rivalry_.state(), seen_, residual_, attitude_, replaced_, refused_, in_a_row_};
}

void GyrLearner::restore(const State& s) noexcept {
  published_.restore(s.published);
  rival_.restore(s.rival);
  rivalry_.restore(s.rivalry);
  attitude_ = Stretch{};
  replaced_ = s.replaced;
  refused_ = s.refused;
  seen_ = s.seen;
}

void GyrLearner::predict(double dt_s) noexcept {
  published_.predict(dt_s);
  if (rivalry_.is_open()) rival_.predict(dt_s);
}

double GyrLearner::vote() const noexcept {
  if (!rivalry_.is_open() || attitude_.windows == 0) return 0.0;
  return Rivalry::vote(published_.fit_of_stretch(attitude_), rival_.fit_of_stretch(attitude_));
}

void GyrLearner::open_rival(const Vec3& up_body) noexcept {
  rival_ = published_;
  rival_.discard_stretch();
  rival_.open_bias(kRivalBias_radps);
  rival_.forget_agreement();
  rivalry_.open(up_body);
  off_.setZero();
  off_information_.setZero();
  attitude_.windows = 0;  // from here on: what was before may have been another bias
}

/// Each attitude alone may be a turn or an unlucky one; what is the same in the body through many is an offset.
bool GyrLearner::off_in_many_attitudes() noexcept {
  const StretchError e = published_.error_of_stretch(attitude_);
  const Mat3 information = e.covariance.inverse();
  off_ += information * e.value;
  off_information_ += information;
  const double chi2 = off_.dot(off_information_.inverse() * off_);
  if (chi2 < kNotOff) {  // the offset, if there is one, begins after this attitude
    off_.setZero();
    off_information_.setZero();
  }
  return chi2 > kOff;
}

/// A bias that wanders faster than assumed, as with a temperature that nobody tells: attitude after attitude is off to
/// the same side. Judged by their own scatter, for of their noise more is assumed than there is.
void GyrLearner::follow_drift() noexcept {
  const Vec3 off = published_.error_of_stretch(attitude_).value;
  drift_radps_ += kDriftShare * (off - drift_radps_);
  drift_sq_ += kDriftShare * (off.squaredNorm() - drift_sq_);
  if (drift_radps_.squaredNorm() > kOneSided * drift_sq_) published_.open_bias(drift_radps_.norm());
}

/// The attitude speaks once, when it is over.
void GyrLearner::end_attitude() noexcept {
  const double for_rival = vote();  // by the noise that was known before it
  if (published_.see(attitude_, kRestGate)) follow_drift();
  if (rivalry_.is_open()) {
    rival_.see(attitude_, kRestGate);
    rivalry_.add_vote(for_rival, vec(attitude_.up));
    switch (rivalry_.verdict(kAttitudesNeeded)) {
      case Rivalry::Verdict::kRivalWins:
        std::swap(published_, rival_);
        rivalry_.exchanged();
        replaced_ = 1;
        drift_radps_.setZero();
        drift_sq_ = 0.0;
        break;
      case Rivalry::Verdict::kPublishedStays:
        rivalry_.close();
        break;
      case Rivalry::Verdict::kOpen:
        break;
    }
  } else if (off_in_many_attitudes()) {
    open_rival(vec(attitude_.up));
  }
  attitude_.windows = 0;
}

bool GyrLearner::absorb(const Window& w, double direction_sd) noexcept {
  RestRate r;
  r.rate_radps = vec(w.gyr_radps) - factory_.bias_at(w.temp_degC);
  r.covariance = mat(w.gyr_cov);
  r.turn_covariance = mat(w.turn_cov);
  r.rounding_var = vec(w.gyr_rounding_var);
  r.up_body = vec(w.acc_mps2).normalized();
  r.direction_sd = direction_sd;
  r.tau = tau(w.temp_degC);
  r.temp_degC = w.temp_degC;
  r.t_ns = w.t_end_ns;
  if (!r.rate_radps.allFinite() || !r.up_body.allFinite()) return false;
  const bool turn_excluded = r.turn_covariance.trace() < 3.0 * kTurnExcluded_radps * kTurnExcluded_radps;
  if (attitude_.windows > 0 &&
      (w.moved || !attitude_.same_attitude(r) || (turn_excluded && attitude_.windows >= kWindowsAsAttitude)))
    end_attitude();
  published_.separate(r, w.moved);
  if (rivalry_.is_open()) rival_.separate(r, w.moved);
  const bool refused = published_.fit(r).chi2 > kRestGate;
  in_a_row_ = refused ? in_a_row_ + 1 : 0;
  const Vec3 e = r.rate_radps - published_.now().at(r.tau, r.tau * r.tau);
  vec(residual_) += kResidualMemory * (e - vec(residual_));
  if (refused && in_a_row_ >= kRestsRefusedToOpen && !rivalry_.is_open()) open_rival(r.up_body);
  attitude_.add(r);
  if (!refused)
    published_.take(r);
  else
    ++refused_;
  if (rivalry_.is_open() && (!rivalry_.rival_is_former() || rival_.fit(r).chi2 < kRestGate)) rival_.take(r);
  seen_.add(r.up_body);
  if (published_.windows() == 0 && rivalry_.is_open() && attitude_.windows >= kRefusedAtFirst) {
    published_ = rival_;  // nothing was learnt that could be defended
    rivalry_.close();
  }
  return true;
}

bool GyrLearner::turn_seen() noexcept {
  attitude_.windows = 0;
  const std::uint32_t discarded = published_.discard_stretch() + (rivalry_.is_open() ? rival_.discard_stretch() : 0);
  return discarded > 0;
}

/// What the filter cannot know: a turn in the only attitude, and a change that is no refusal yet.
Mat3 GyrLearner::doubt(const GyrFilter& present, double tau) const noexcept {
  Mat3 out = vec(attitude_.rounding_var).asDiagonal();  // every rest has the same: it does not average out
  if (seen_.count <= 1) {
    const Vec3 unseen = attitude_.unseen_axis();
    out += kOneAttitude_radps * kOneAttitude_radps * unseen * unseen.transpose();
  }
  const Vec3 e = vec(residual_);
  const double floor = 3.0 * params_.mean_floor_radps;
  const Mat3 S = present.covariance_at(tau, tau * tau) + mat(attitude_.covariance) + floor * floor * Mat3::Identity();
  if (e.dot(S.inverse() * e) > kContradicted) out += kChangedAtAll * e * e.transpose();
  return out;
}

void GyrLearner::publish(double temp_degC, const SeenTemperatures& seen, TriadCalibration& out) noexcept {
  const GyrFilter present = published_.now();
  const double t = tau(temp_degC);
  Mat3 c = present.polynomial();
  const Vec3 now = present.at(t, t * t);
  const auto follows = present.follows_temperature(tau(seen.min_degC), tau(seen.max_degC));
  for (int axis = 0; axis < 3; ++axis)
    if (!follows[static_cast<std::size_t>(axis)]) c.row(axis) << now[axis], 0.0, 0.0;
  const double s = kTempScale_K;
  out.bias = array(Vec3(vec(factory_.bias) + c.col(0)));
  out.bias_per_K = array(Vec3(vec(factory_.bias_per_K) + c.col(1) / s));
  out.bias_per_K2 = array(Vec3(vec(factory_.bias_per_K2) + c.col(2) / (s * s)));
  out.temp_min_degC = seen.min_degC;
  out.temp_max_degC = seen.max_degC;
  Mat3 P = present.covariance_at(t, t * t) + doubt(present, t);
  if (const double weight = rivalry_.weight(vote()); weight > 0.0) {
    const GyrFilter other = rival_.now();
    const Vec3 apart = other.at(t, t * t) - now;
    P += weight * (other.covariance_at(t, t * t) + apart * apart.transpose());
  }
  out.bias_covariance = array(P);
  out.norm_sd = std::sqrt(P.trace() / 3.0);
  out.windows = published_.windows();
  const bool known = out.norm_sd < kKnownAgain * params_.bias_sd_radps;
  if (known && !rivalry_.is_open()) replaced_ = 0;
  out.status = replaced_ != 0    ? CalibrationStatus::kReplaced
               : out.windows > 0 ? CalibrationStatus::kOk
                                 : CalibrationStatus::kTooFewWindows;
}

}  // namespace stillpoint::calib

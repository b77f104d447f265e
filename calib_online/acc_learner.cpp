#include "calib_online/acc_learner.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace stillpoint::calib {
namespace {

constexpr double kWindowGate_sd = 4.0;        // sd; beyond, a window is refused
constexpr double kHuber_sd = 1.5;             // sd; beyond, a window counts less
constexpr double kSameDirection = 0.985;      // cosine of 10 degrees
constexpr double kSameDirectionLimit = 10.0;  // Gietzelt 2.4: up to ten measurements of a direction
constexpr double kShortWay_rad = 0.1;         // 2 % of it are 2 mrad
constexpr double kNewAttitude = 0.92;         // cosine of 23 degrees: it may speak
constexpr double kErrorMemory = 0.98;
constexpr double kDoubtComes = 1.0, kDoubtGoes = 0.1;  // share of one attitude in what is unexplained
constexpr double kLeastNoise = 0.25;                   // of the assumed variance
constexpr double kMostlyNoise = 0.5;                   // of an error: what is known is the smaller part
constexpr std::uint32_t kRefusedToOpen = 2;            // in a row: a single window may have been pushed
constexpr std::uint32_t kAttitudesToWin = 4;           // to win, and to have learnt something worth defending

}  // namespace

AccLearner::AccLearner(const AccLearnerParams& params, const TriadCalibration& factory)
    : params_(params),
      factory_(factory),
      published_(params.filter, params.gravity_mps2),
      rival_(params.filter, params.gravity_mps2),
      cells_(params.cells) {}

AccLearner::State AccLearner::state() const noexcept {
  State out = s_;
  out.published = published_.state();
  out.rival = rival_.state();
  out.cells = cells_.state();
  out.rivalry = rivalry_.state();
  return out;
}

void AccLearner::restore(const State& s) noexcept {
  s_ = s;
  published_.restore(s.published);
  rival_.restore(s.rival);
  cells_.restore(s.cells);
  rivalry_.restore(s.rivalry);
}

double AccLearner::tau(double temp_degC) const noexcept { return (temp_degC - factory_.temp_ref_degC) / kTempScale_K; }

void AccLearner::predict(double dt_s) noexcept {
  published_.predict(dt_s);
  if (rivalry_.is_open()) rival_.predict(dt_s);
}

/// Of 1 - d^T p in this window, as far as the window goes.
double AccLearner::variance_of(const Window& w, const Vec3& x) noexcept {
  const double g = params_.gravity_mps2;
  const Vec3 up = x.normalized();
  const Vec3 n = mat(factory_.matrix).transpose() * up;
  const double norm_var = n.dot(mat(w.acc_cov) * n) + squared(params_.filter.norm_floor_mps2);
  const bool same = up.dot(vec(s_.last_direction)) > kSameDirection;
  const Array4& q = w.q_previous_this;
  const Vec3 before = vec(s_.last_direction), turned = Quat(q[0], q[1], q[2], q[3]) * up;
  // Of a longer way the gyroscope's scale leaves too much; of an offset that is not known yet, whichever is smaller.
  const bool short_way = w.rotation_valid && w.rotation_path_rad < kShortWay_rad;
  const double step_rad = short_way ? std::min((up - before).norm(), (turned - before).norm()) : 0.0;
  s_.unrest.see(x.norm(), same, step_rad);
  double variance = 4.0 * std::max(s_.noise.variance_scale(kLeastNoise) * norm_var / (g * g), s_.unrest.variance());
  // The same direction again and again is one reading with one unmodelled error: its weight stops growing at ten.
  s_.same_direction = same ? s_.same_direction + 1 : 0;
  s_.last_direction = array(up);
  variance *= std::max(1.0, s_.same_direction / kSameDirectionLimit);
  // Inside a cell such windows share what the slope makes of its width: one unknown of the whole run.
  const bool same_run = same && std::abs(w.temp_degC - s_.run_temp_degC) < 0.5 * params_.cells.spacing_K;
  s_.run_windows = same_run ? s_.run_windows + 1 : 0;
  if (!same_run) s_.run_temp_degC = w.temp_degC;
  return variance;
}

bool AccLearner::absorb(const Window& w) noexcept {
  const Vec3 x = factory_.apply(w.acc_mps2, w.temp_degC) / params_.gravity_mps2;
  if (!x.allFinite()) return false;
  const double calm = variance_of(w, x), sideways = 4.0 * s_.unrest.sideways_variance();
  const double variance = calm + sideways;
  const AccFilter::Innovation e = innovation(x, w.temp_degC);
  const double ratio = std::abs(e.value) / std::sqrt(e.variance + variance + slope_variance());
  // What is known well is not given up to a push: it is refused as if there were none.
  const bool refused = squared(e.value) > squared(kWindowGate_sd) * (e.variance + calm + slope_variance());
  if (s_.same_direction == 0 && !refused && e.variance < variance) follow_drift(e, variance);
  hear(x, w.temp_degC, variance, refused);
  if (refused) {
    ++s_.refused;
    return true;
  }
  // A window of unrest is no judge between the two.
  const double say = squared(2.0 * params_.filter.norm_floor_mps2 / params_.gravity_mps2) / variance;
  s_.factory_error = kErrorMemory * s_.factory_error + say * squared(x.squaredNorm() - 1.0);
  s_.learnt_error = kErrorMemory * s_.learnt_error + say * squared(e.value);
  s_.error_weight = kErrorMemory * s_.error_weight + say;
  // Nor is one that counts less for its direction: beside what is assumed of it then, it agrees too well.
  const bool fresh = s_.same_direction < kSameDirectionLimit;
  if (fresh && e.variance < kMostlyNoise * variance && 4.0 * s_.unrest.variance() + sideways < calm)
    s_.noise.see(ratio * ratio * s_.noise.variance_scale(kLeastNoise), 1.0);
  learn(x, w, variance, std::max(1.0, ratio / kHuber_sd));
  s_.learnt_in.add(x.normalized());
  ++s_.windows;
  return true;
}

/// Another sensor, a blow, a wrong range: as far from the prior as the surprise is large.
void AccLearner::open_rival(const Vec3& up_body, double surprise) noexcept {
  if (s_.learnt_in.count >= kAttitudesToWin && polynomial())
    rival_.restore(published_.state());
  else
    rival_.reset();
  rival_.open(0.5 * std::abs(surprise));  // the entries are squares of the norm
  rivalry_.open(up_body);
  s_.voted_up = array(up_body);
  s_.noise = {};  // that the sensor agreed until now is no evidence of another one
}

/// What a window says of the two hypotheses, and to the rival. An attitude speaks once, by its first window.
void AccLearner::hear(const Vec3& x, double temp_degC, double variance, bool refused) noexcept {
  const Vec3 up = x.normalized();
  s_.in_a_row = refused ? s_.in_a_row + 1 : 0;
  if (!rivalry_.is_open() && s_.in_a_row < kRefusedToOpen) return;
  const double t = tau(temp_degC);
  const AccFilter::Innovation published = innovation(x, temp_degC);
  if (!rivalry_.is_open()) open_rival(up, published.value);
  const AccFilter::Innovation rival = rival_.innovation(x, t);
  const double S0 = published.variance + variance + slope_variance(), S = rival.variance + variance;
  const double vote =
      Rivalry::vote({squared(published.value) / S0, std::log(S0), S0}, {squared(rival.value) / S, std::log(S), S});
  const bool first = up.dot(vec(s_.voted_up)) < kNewAttitude;
  if (first) {
    rivalry_.add_vote(vote, up);
    s_.voted_up = array(up);
  }
  s_.pending = first ? 0.0 : std::min(0.0, vote);
  const double ratio = std::abs(rival.value) / std::sqrt(S);
  if (!rivalry_.rival_is_former() || ratio < kWindowGate_sd)
    rival_.update(x, t, variance * std::max(1.0, ratio / kHuber_sd));
  const auto verdict = rivalry_.verdict(kAttitudesToWin);
  if (verdict == Rivalry::Verdict::kRivalWins) exchange();
  if (verdict == Rivalry::Verdict::kPublishedStays) rivalry_.close();
}

void AccLearner::exchange() noexcept {
  const AccFilter::State before = published_.state();
  published_.restore(rival_.state());
  rival_.restore(before);
  rivalry_.exchanged();
  if (!polynomial()) {  // what cells hold cannot be kept beside
    cells_.restore({});
    rivalry_.close();
  }
  s_.replaced = 1;
  s_.factory_error = s_.learnt_error = s_.error_weight = 0.0;
}

/// A bias that wanders faster than assumed, as with a temperature that nobody tells: attitude after attitude is off by
/// more than was stated.
void AccLearner::follow_drift(const AccFilter::Innovation& e, double variance) noexcept {
  const double stated = e.variance + variance;
  const double excess = std::min(squared(e.value), squared(kWindowGate_sd) * stated) - stated;
  unexplained_ += (excess > unexplained_ ? kDoubtComes : kDoubtGoes) * (excess - unexplained_);
}

void AccLearner::learn(const Vec3& x, const Window& w, double variance, double doubt) noexcept {
  if (polynomial()) {
    published_.update(x, tau(w.temp_degC), variance * doubt);
    return;
  }
  // (T14): what the window adds to a run of windows that share the slope's error.
  const double slope = slope_variance(), before = s_.run_windows;
  const double information = variance / ((variance + before * slope) * (variance + (before + 1.0) * slope));
  const Mat3 to_x = mat(factory_.matrix) / params_.gravity_mps2;
  cells_.add(x, Mat3(to_x * mat(w.acc_cov) * to_x.transpose()), w.temp_degC,
             std::min(1.0, window_variance() * information / doubt));
}

/// Of 1 - d^T p: what the slope makes of the width of a cell.
double AccLearner::slope_variance() const noexcept {
  if (params_.model != TemperatureModel::kCells) return 0.0;
  const double across_mps2 = params_.filter.bias_per_K_sd_mps2 * params_.cells.spacing_K;
  return 4.0 * squared(across_mps2 / params_.gravity_mps2) / 12.0;
}

/// The same in one window of weight one: the floor of its norm and, in a cell, the slope.
double AccLearner::window_variance() const noexcept {
  return 4.0 * squared(params_.filter.norm_floor_mps2 / params_.gravity_mps2) + slope_variance();
}

AccLearner::Estimate AccLearner::estimate(double temp_degC) const noexcept {
  const auto& a = params_.filter;
  const double g = params_.gravity_mps2, t = tau(temp_degC);
  if (polynomial()) return {published_.at(t), published_.covariance_at(t), true};
  if (params_.model == TemperatureModel::kNone) {
    const MapFit fit =
        map_fit(cells_.all(), 0.5 * std::sqrt(window_variance()), {a.scale_sd, a.shear_sd, a.bias_sd_mps2 / g});
    return {fit.p, fit.covariance, fit.status == FitStatus::kOk};
  }
  return cells_.at(temp_degC, {.variance = published_.prior_variance().head<TemperatureCells::kTrend>(),
                               .temp_ref_degC = factory_.temp_ref_degC,
                               .local_variance = 4.0 * squared(a.wander_sd_mps2 / g),
                               .window_variance = window_variance()});
}

/// With what the rival makes of it: the stated deviation grows while evidence contradicts.
AccLearner::Estimate AccLearner::doubted(double temp_degC) const noexcept {
  Estimate e = estimate(temp_degC);
  e.covariance.diagonal().tail<3>().array() += std::max(0.0, unexplained_);
  const double weight = rivalry_.weight(s_.pending);
  if (!e.valid || weight == 0.0) return e;
  const double t = tau(temp_degC);
  const Vec9 apart = rival_.at(t) - e.p;
  e.covariance += weight * (rival_.covariance_at(t) + apart * apart.transpose());
  return e;
}

Vec9 AccLearner::entries(double temp_degC) const noexcept {
  return polynomial() ? published_.at(tau(temp_degC)) : estimate(temp_degC).p;
}

AccFilter::Innovation AccLearner::innovation(const Vec3& x, double temp_degC) const noexcept {
  const Estimate learnt = polynomial() ? Estimate{} : estimate(temp_degC);
  if (!learnt.valid) return published_.innovation(x, tau(temp_degC));
  const Vec9 d = quadric_terms(x);
  return {1.0 - d.dot(learnt.p), d.dot(learnt.covariance * d)};
}

}  // namespace stillpoint::calib

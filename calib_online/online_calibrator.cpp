#include "calib_online/online_calibrator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace stillpoint::calib {
namespace {

constexpr double kGate = 4.0;             // sd; beyond, a window is set aside
constexpr double kHuber = 1.5;            // sd; beyond, a window counts less
constexpr std::uint32_t kRunToWiden = 8;  // windows set aside in a row: not outliers, the sensor changed
constexpr std::uint32_t kWideningsToReset = 3;
constexpr double kSameDirection = 0.985;           // cosine of 10 degrees
constexpr std::uint32_t kSameDirectionLimit = 10;  // Gietzelt 2.4: up to ten measurements of a direction
constexpr double kErrorMemory = 0.98;

double squared(double v) { return v * v; }

}  // namespace

std::string check(const OnlineCalibratorParams& params) {
  const std::string& model = params.temperature_model;
  if (model == "none" || model == "cells" || model == "polynomial") return {};
  return "temperature_model is '" + model + "'; it must be none, cells or polynomial";
}

OnlineCalibrator::OnlineCalibrator(const Params& params, const CalibrationSnapshot& factory)
    : params_(params),
      factory_(factory),
      snapshot_(factory),
      model_(params.temperature_model == "none"    ? TemperatureModel::kNone
             : params.temperature_model == "cells" ? TemperatureModel::kCells
                                                   : TemperatureModel::kPolynomial),
      acc_(params.accelerometer, params.gravity_mps2),
      cells_(params.temperature_cells),
      gyr_(params.gyroscope),
      field_(params.magnetometer) {
  publish_gyr_matrix();
  s_.sound = {factory.acc.status, factory.gyr.status, factory.mag.status};
}

double OnlineCalibrator::tau(double temp_degC, const TriadCalibration& factory) const noexcept {
  return (temp_degC - factory.temp_ref_degC) / kTempScale_K;
}

OnlineCalibrator::State OnlineCalibrator::state() const noexcept {
  State out = s_;
  out.version = State::kVersion;
  out.bytes = sizeof(State);
  out.acc = acc_.state();
  out.acc_cells = cells_.state();
  out.gyr = gyr_.state();
  out.field = field_.state();
  out.snapshot_version = snapshot_.version;
  return out;
}

bool OnlineCalibrator::restore(std::span<const std::byte> bytes) noexcept {
  State state;
  if (bytes.size() != sizeof state) return false;
  std::memcpy(&state, bytes.data(), sizeof state);
  return restore(state);
}

bool OnlineCalibrator::restore(const State& state) noexcept {
  if (state.version != State::kVersion || state.bytes != sizeof(State)) return false;
  const auto all_finite = [](const auto& a) {
    return std::all_of(a.begin(), a.end(), [](double v) { return std::isfinite(v); });
  };
  if (!all_finite(state.acc.x) || !all_finite(state.acc.P.a) || !all_finite(state.gyr.x) ||
      !all_finite(state.gyr.P.a) || !all_finite(state.field.x) || !all_finite(state.field.P.a) ||
      !std::all_of(state.acc_cells.begin(), state.acc_cells.end(),
                   [&](const auto& c) { return all_finite(c.sums.sums()) && std::isfinite(c.temp_sum); }) ||
      !all_finite(state.stretch_rate) || !all_finite(state.stretch_cov) || !all_finite(state.stretch_turn_cov)) {
    return false;
  }
  s_ = state;
  acc_.restore(state.acc);
  cells_.restore(state.acc_cells);
  gyr_.restore(state.gyr);
  field_.restore(state.field);
  snapshot_.version = state.snapshot_version;
  snapshot_.t_ns = state.t_ns;
  commit_stretch();
  const double temp_degC = s_.temp_known ? 0.5 * (s_.temp_min_degC + s_.temp_max_degC) : factory_.acc.temp_ref_degC;
  if (s_.acc_windows > 0) publish_acc(temp_degC);
  if (s_.gyr_windows > 0) publish_gyr(temp_degC);
  publish_gyr_matrix();
  if (state.field.pairs > 0) publish_mag();
  s_.stuck = s_.clipped = 0;
  s_.sound = {snapshot_.acc.status, snapshot_.gyr.status, snapshot_.mag.status};
  s_.has_previous = false;  // where the body was before the restart says nothing of a turn since
  return true;
}

bool OnlineCalibrator::absorb(const Window& window) noexcept {
  snapshot_.acc.status = s_.sound[0];
  snapshot_.gyr.status = s_.sound[1];
  snapshot_.mag.status = s_.sound[2];
  const bool faults_changed = window.stuck != s_.stuck || window.clipped != s_.clipped;
  s_.stuck = window.stuck;
  s_.clipped = window.clipped;
  const bool changed = ((window.has & (kAcc | kGyr | kMag)) != 0 && learn(window)) || faults_changed;
  for (std::size_t k = 0; k < 3; ++k) name_fault(k);
  if (changed) {
    ++snapshot_.version;
    snapshot_.t_ns = window.t_end_ns;
  }
  return changed;
}

/// What a triad (acc, gyr, mag) that is stuck or clipped has learnt stays; its status says that it cannot be relied on
/// now.
void OnlineCalibrator::name_fault(std::size_t triad) noexcept {
  const std::array<TriadCalibration*, 3> triads{&snapshot_.acc, &snapshot_.gyr, &snapshot_.mag};
  CalibrationStatus& status = triads[triad]->status;
  s_.sound[triad] = status;
  if ((s_.clipped & kTriadBits[triad]) != 0) status = CalibrationStatus::kClipped;
  if ((s_.stuck & kTriadBits[triad]) != 0) status = CalibrationStatus::kStuck;
}

bool OnlineCalibrator::learn(const Window& window) noexcept {
  predict(window.t_end_ns);
  const bool known = (window.has & kTemp) != 0;
  const double temp_degC = known ? window.temp_degC : factory_.acc.temp_ref_degC;
  if (!s_.temp_known) s_.temp_min_degC = s_.temp_max_degC = temp_degC;
  s_.temp_known = true;
  s_.temp_min_degC = std::min(s_.temp_min_degC, temp_degC);
  s_.temp_max_degC = std::max(s_.temp_max_degC, temp_degC);
  bool changed = (window.has & kAcc) != 0 && absorb_acc(window);
  if (window.refusal == Refusal::kTurning && s_.stretch_windows > 0) {
    // The turn did not begin when it was seen: the whole stretch is set aside.
    s_.gyr_windows -= s_.stretch_windows;
    s_.stretch_windows = 0;
    publish_gyr(temp_degC);
    changed = true;
  }
  changed = ((window.has & kGyr) != 0 && absorb_gyr(window)) || changed;
  return absorb_turn(window) || changed;
}

void OnlineCalibrator::predict(std::int64_t t_ns) noexcept {
  // A clock that starts again (a new run on a persisted state) says nothing of the time between.
  const double dt_s = s_.t_ns > 0 && t_ns > s_.t_ns ? static_cast<double>(t_ns - s_.t_ns) * kSecondsPerNs : 0.0;
  s_.t_ns = t_ns;
  acc_.predict(dt_s);
  if (s_.stretch_windows == 0) gyr_.predict(dt_s);
}

bool OnlineCalibrator::absorb_acc(const Window& w) noexcept {
  const double g = params_.gravity_mps2;
  const Vec3 x = factory_.acc.apply(w.acc_mps2, w.temp_degC) / g;
  if (!x.allFinite()) return false;
  const Vec3 n = mat(factory_.acc.matrix).transpose() * x.normalized();
  const double norm_var = n.dot(mat(w.acc_cov) * n) + squared(params_.accelerometer.norm_floor_mps2);
  double variance = 4.0 * norm_var / (g * g);
  // The same direction again and again is one reading with one unmodelled error: its weight stops growing at ten.
  const bool same = x.normalized().dot(vec(s_.last_direction)) > kSameDirection;
  s_.same_direction = same ? s_.same_direction + 1 : 0;
  s_.last_direction = array(Vec3(x.normalized()));
  variance *= std::max(1.0, static_cast<double>(s_.same_direction) / kSameDirectionLimit);

  // Inside a cell such windows share what the slope makes of its width: one unknown of the whole run.
  const bool same_run = same && std::abs(w.temp_degC - s_.run_temp_degC) < 0.5 * params_.temperature_cells.spacing_K;
  s_.run_windows = same_run ? s_.run_windows + 1 : 0;
  if (!same_run) s_.run_temp_degC = w.temp_degC;

  const AccFilter::Innovation innovation = acc_innovation(x, w.temp_degC);
  const double sd = std::sqrt(innovation.variance + variance + slope_variance());
  const double ratio = std::abs(innovation.value) / sd;
  if (ratio > kGate) {
    if (++s_.acc_rejected_run < kRunToWiden) return false;
    s_.acc_rejected_run = 0;
    if (++s_.widenings >= kWideningsToReset) {
      acc_.reset();
      cells_.restore({});
      s_.widenings = 0;
      s_.acc_windows = 0;
    }
    acc_.widen(1.0);
    accelerometer_replaced();
    return true;
  }
  s_.acc_rejected_run = 0;
  s_.factory_error = kErrorMemory * s_.factory_error + squared(x.squaredNorm() - 1.0);
  s_.learnt_error = kErrorMemory * s_.learnt_error + squared(innovation.value);
  s_.error_weight = kErrorMemory * s_.error_weight + 1.0;
  learn_acc(x, w, variance, std::max(1.0, ratio / kHuber));
  ++s_.acc_windows;
  publish_acc(w.temp_degC);
  return true;
}

/// Another sensor, or a blow: nothing that was learnt is published until it is known anew.
void OnlineCalibrator::accelerometer_replaced() noexcept {
  s_.acc_replaced = true;
  s_.factory_error = s_.learnt_error = s_.error_weight = 0.0;
  const std::uint32_t windows = s_.acc_windows;
  snapshot_.acc = factory_.acc;
  snapshot_.acc.windows = windows;
  snapshot_.acc.status = CalibrationStatus::kReplaced;
}

void OnlineCalibrator::learn_acc(const Vec3& x, const Window& w, double variance, double doubt) noexcept {
  if (model_ == TemperatureModel::kPolynomial) {
    acc_.update(x, tau(w.temp_degC, factory_.acc), variance * doubt);
    return;
  }
  // (T14): what the window adds to a run of windows that share the slope's error.
  const double slope = slope_variance(), before = s_.run_windows;
  const double information = variance / ((variance + before * slope) * (variance + (before + 1.0) * slope));
  const Mat3 to_x = mat(factory_.acc.matrix) / params_.gravity_mps2;
  cells_.add(x, Mat3(to_x * mat(w.acc_cov) * to_x.transpose()), w.temp_degC,
             std::min(1.0, window_variance() * information / doubt));
}

/// Of 1 - d^T p: what the slope makes of the width of a cell.
double OnlineCalibrator::slope_variance() const noexcept {
  if (model_ != TemperatureModel::kCells) return 0.0;
  const double across_mps2 = params_.accelerometer.bias_per_K_sd_mps2 * params_.temperature_cells.spacing_K;
  return 4.0 * squared(across_mps2 / params_.gravity_mps2) / 12.0;
}

/// The same in one window of weight one: the floor of its norm and, in a cell, the slope.
double OnlineCalibrator::window_variance() const noexcept {
  return 4.0 * squared(params_.accelerometer.norm_floor_mps2 / params_.gravity_mps2) + slope_variance();
}

OnlineCalibrator::AccEstimate OnlineCalibrator::acc_estimate(double temp_degC) const noexcept {
  const auto& a = params_.accelerometer;
  const double g = params_.gravity_mps2, t = tau(temp_degC, factory_.acc);
  if (model_ == TemperatureModel::kPolynomial) return {acc_.at(t), acc_.covariance_at(t), true};
  if (model_ == TemperatureModel::kNone) {
    const MapFit fit =
        map_fit(cells_.all(), 0.5 * std::sqrt(window_variance()), {a.scale_sd, a.shear_sd, a.bias_sd_mps2 / g});
    return {fit.p, fit.covariance, fit.status == FitStatus::kOk};
  }
  return cells_.at(temp_degC, {.variance = acc_.prior_variance().head<TemperatureCells::kTrend>(),
                               .temp_ref_degC = factory_.acc.temp_ref_degC,
                               .local_variance = 4.0 * squared(a.wander_sd_mps2 / g),
                               .window_variance = window_variance()});
}

Vec9 OnlineCalibrator::acc_entries(double temp_degC) const noexcept {
  if (model_ == TemperatureModel::kPolynomial) return acc_.at(tau(temp_degC, factory_.acc));
  return acc_estimate(temp_degC).p;
}

AccFilter::Innovation OnlineCalibrator::acc_innovation(const Vec3& x, double temp_degC) const noexcept {
  const AccEstimate learnt = model_ == TemperatureModel::kPolynomial ? AccEstimate{} : acc_estimate(temp_degC);
  if (!learnt.valid) return acc_.innovation(x, tau(temp_degC, factory_.acc));
  const Vec9 d = quadric_terms(x);
  return {1.0 - d.dot(learnt.p), d.dot(learnt.covariance * d)};
}

void OnlineCalibrator::publish_acc(double temp_degC) noexcept {
  const double g = params_.gravity_mps2;
  const double t = tau(temp_degC, factory_.acc);
  TriadCalibration& out = snapshot_.acc;
  const AccEstimate estimate = acc_estimate(temp_degC);
  const auto here = estimate.valid ? ellipsoid(estimate.p) : std::nullopt;
  // Worse than the prior on the windows themselves: the factory values serve until that is over.
  const bool worse = s_.error_weight > 5.0 && s_.learnt_error > 1.2 * s_.factory_error;
  if (!here || worse) {
    const std::uint32_t windows = s_.acc_windows;
    out = factory_.acc;
    out.windows = windows;
    out.status = !here             ? CalibrationStatus::kNotPositiveDefinite
                 : s_.acc_replaced ? CalibrationStatus::kReplaced
                                   : CalibrationStatus::kFactory;
    return;
  }
  const Mat3 H_f = mat(factory_.acc.matrix);
  const Mat3 to_reading = g * H_f.inverse();
  // The centre at three temperatures gives the polynomial of the bias; the matrix is that of now.
  const double step = 0.2;  // 5 K
  const auto colder = ellipsoid(acc_entries(temp_degC - step * kTempScale_K)),
             warmer = ellipsoid(acc_entries(temp_degC + step * kTempScale_K));
  const Vec3 c0 = here->centre;
  const Vec3 c1 = colder && warmer ? Vec3((warmer->centre - colder->centre) / (2.0 * step)) : Vec3(Vec3::Zero());
  const Vec3 c2 =
      colder && warmer ? Vec3((warmer->centre - 2.0 * c0 + colder->centre) / (2.0 * step * step)) : Vec3(Vec3::Zero());
  const double s = kTempScale_K;
  out.matrix = array(Mat3(here->K * H_f));
  out.bias = array(Vec3(vec(factory_.acc.bias) + to_reading * (c0 - t * c1 + t * t * c2)));
  out.bias_per_K = array(Vec3(vec(factory_.acc.bias_per_K) + to_reading * (c1 - 2.0 * t * c2) / s));
  out.bias_per_K2 = array(Vec3(vec(factory_.acc.bias_per_K2) + to_reading * c2 / (s * s)));
  out.temp_ref_degC = factory_.acc.temp_ref_degC;
  out.temp_min_degC = s_.temp_min_degC;
  out.temp_max_degC = s_.temp_max_degC;
  const Mat9& C = estimate.covariance;
  out.bias_covariance = array(Mat3(0.25 * to_reading * C.bottomRightCorner<3, 3>() * to_reading.transpose()));
  out.norm_sd = g * std::sqrt(mean_norm_variance(C));
  out.windows = s_.acc_windows;
  const Mat9 C0 = acc_.prior_covariance_at(t);
  // Twice as good as the prior in the mean, even where it is worst.
  const bool known = worst_norm_variance(C).variance < 0.3 * mean_norm_variance(C0);
  s_.acc_replaced = s_.acc_replaced && !known;
  out.status = known ? CalibrationStatus::kOk
               : s_.acc_replaced
                   ? CalibrationStatus::kReplaced
                   : (s_.acc_windows < 12 ? CalibrationStatus::kTooFewWindows : CalibrationStatus::kNotObservable);
}

}  // namespace stillpoint::calib

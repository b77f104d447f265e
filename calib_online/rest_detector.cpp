#include "calib_online/rest_detector.h"
#include "core/units.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stillpoint::calib {
namespace {

constexpr double kMovedRate_radps = 0.35;  // faster than any turn a stretch of rest could hide
constexpr double kDriftMemory_s = 0.1;     // of the mean that every sample since a window feeds
constexpr double kDriftSpreads = 2.0;      // of the spread that a window of rest may have: beyond, it is over
constexpr double kSampleSd = 6.0;          // one sample in 1e8 by chance, an axis

void keep_least(double step, double& least) noexcept {
  if (least == 0.0 || step < least) least = step;
}
bool beyond(const Array3& a, double limit) noexcept {
  return std::abs(a[0]) >= limit || std::abs(a[1]) >= limit || std::abs(a[2]) >= limit;
}

}  // namespace

RestDetector::RestDetector(const Params& params)
    : params_(params), quarter_ns_(static_cast<std::int64_t>(params.window_s / kQuarters * kNsPerSecond)) {
  last_raw_.fill(Vec3::Zero());
  noisy_.fill({});
  lattice_.fill(Vec3::Zero());
}

std::optional<Window> RestDetector::push(const RawSample& sample, const CalibrationSnapshot& calibration) noexcept {
  const double temp_degC = sample.holds(kTemp) && std::isfinite(sample.temp_degC)
                               ? sample.temp_degC
                               : (current_.temp_count > 0 ? current_.temp_sum / current_.temp_count : 25.0);
  // Time does not run backwards here; a sample that does belongs to another run.
  if (has_last_ && (sample.t_ns <= last_t_ns_ || 2 * (sample.t_ns - last_t_ns_) > quarter_ns_)) {
    restart();
    chain_.broken = true;
    moved();
    last_refusal_ = Refusal::kGap;
  } else if (has_last_) {
    integrate(sample, calibration, temp_degC);
    if (at_rest()) hold_against_rest(sample, in_seconds(sample.t_ns - last_t_ns_));
  }
  std::optional<Window> window;
  if (open_ && sample.t_ns - current_.t_first_ns >= quarter_ns_) {
    if (filled_ == kQuarters) {
      std::copy(quarters_.begin() + 1, quarters_.end(), quarters_.begin());
      --filled_;
    }
    quarters_[static_cast<std::size_t>(filled_++)] = current_;
    open_ = false;
    if (filled_ == kQuarters) window = evaluate(calibration);
  }
  if (!open_) begin_quarter(sample);
  add(sample, calibration, temp_degC);
  last_t_ns_ = sample.t_ns;
  has_last_ = true;
  return window;
}

/// The next full window is up to two seconds away; whoever holds the rate for zero must know at once.
void RestDetector::hold_against_rest(const RawSample& sample, double dt_s) noexcept {
  const std::array<const Array3*, 2> reading{&sample.acc_mps2, &sample.gyr_radps};
  const std::array<bool, 2> measured{sample.holds(kAcc), sample.holds(kGyr)};
  const std::array<double, 2> spread{params_.acc_spread_mps2, params_.gyr_spread_radps};
  const double share = std::min(1.0, dt_s / kDriftMemory_s);
  bool beyond = false, drifted = false;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!measured[k] || !held_.has[k] || !vec(*reading[k]).allFinite()) continue;
    const Vec3 deviation = vec(*reading[k]) - held_.mean[k];
    held_.drift[k] += share * (deviation - held_.drift[k]);
    const double sd = held_.noise_sd[k];
    const double rest = kDriftSpreads * spread[k];
    beyond = beyond || deviation.squaredNorm() > std::pow(kSampleSd * sd + rest, 2);
    drifted = drifted || held_.drift[k].squaredNorm() > std::pow(kSampleSd * sd * std::sqrt(share / 2.0) + rest, 2);
  }
  held_.beyond = beyond ? held_.beyond + 1 : 0;
  if (held_.beyond >= 2 || drifted) last_refusal_ = Refusal::kSwaying;
}

void RestDetector::restart() noexcept {
  filled_ = 0;
  open_ = false;
  has_last_rate_ = false;
  has_last_raw_.fill(false);
}

/// Another attitude: no direction from before can be compared, no turn from before goes on.
void RestDetector::moved() noexcept {
  moved_ = true;
  anchor_.set = false;
  seen_turn_ = Vec3::Zero();
}

void RestDetector::begin_quarter(const RawSample& sample) noexcept {
  current_ = Quarter{};
  current_.t_first_ns = sample.t_ns;
  current_.chain = chain_;
  open_ = true;
}

/// Trapezoid over the step.
void RestDetector::integrate(const RawSample& sample, const CalibrationSnapshot& calibration,
                             double temp_degC) noexcept {
  if (!sample.holds(kGyr) || !vec(sample.gyr_radps).allFinite()) {
    chain_.broken = chain_.broken || has_last_rate_;
    return;
  }
  const double dt_s = in_seconds(sample.t_ns - last_t_ns_);
  const Mat3 H = mat(calibration.gyr.matrix);
  const Vec3 z_now = vec(sample.gyr_radps) - calibration.gyr.bias_at(temp_degC);
  const Vec3 z = has_last_rate_ ? Vec3(0.5 * (z_now + last_rate_)) : z_now;
  chain_.rotation.advance(z, H, dt_s);
  const double rate_radps = (H * z).norm();
  chain_.angle_rad += rate_radps * dt_s;
  chain_.duration_s += dt_s;
  last_rate_ = z_now;
  has_last_rate_ = true;
  if (rate_radps > kMovedRate_radps) moved();
  if (beyond(sample.gyr_radps, params_.gyr_limit_radps)) chain_.broken = true;
}

void RestDetector::add(const RawSample& sample, const CalibrationSnapshot& calibration, double temp_degC) noexcept {
  const int block = static_cast<int>(
      std::min<std::int64_t>(kBlocks - 1, (sample.t_ns - current_.t_first_ns) * kBlocks / quarter_ns_));
  const Mat3 R_ref_body = chain_.rotation.q.toRotationMatrix();
  if (sample.holds(kAcc) && vec(sample.acc_mps2).allFinite()) {
    add(kAccIndex, sample.acc_mps2, calibration.acc, temp_degC, block, R_ref_body);
    current_.triad[kAccIndex].clipped += beyond(sample.acc_mps2, params_.acc_limit_mps2);
  }
  if (sample.holds(kGyr) && vec(sample.gyr_radps).allFinite()) {
    add(kGyrIndex, sample.gyr_radps, calibration.gyr, temp_degC, block, Mat3::Identity());
    current_.triad[kGyrIndex].clipped += beyond(sample.gyr_radps, params_.gyr_limit_radps);
  }
  if (sample.holds(kMag) && vec(sample.mag_uT).allFinite()) {
    add(kMagIndex, sample.mag_uT, calibration.mag, temp_degC, block, R_ref_body);
    current_.triad[kMagIndex].clipped += beyond(sample.mag_uT, params_.mag_limit_uT);
  }
  if (sample.holds(kTemp) && std::isfinite(sample.temp_degC)) {
    current_.temp_sum += sample.temp_degC;
    ++current_.temp_count;
  }
  ++current_.samples;
  current_.t_last_ns = sample.t_ns;
}

void RestDetector::add(std::size_t w, const Array3& raw, const TriadCalibration& calibration, double temp_degC,
                       int block, const Mat3& R_ref_body) noexcept {
  const auto b = static_cast<std::size_t>(block);
  Triad& triad = current_.triad[w];
  const Vec3 u = calibration.apply(raw, temp_degC);
  const Vec3 u_ref = R_ref_body * u;
  triad.block[b] += u;
  triad.block_ref[b] += u_ref;
  triad.sum_sq += u_ref.cwiseProduct(u_ref);
  ++triad.n[b];
  if (has_last_raw_[w]) {
    // Of the raw readings: a new version of the calibration, or of the temperature, is no change of a stuck sensor.
    const Vec3 step = vec(raw) - last_raw_[w];
    triad.step_sq += (mat(calibration.matrix) * step).squaredNorm();
    triad.raw_step_sq += step.cwiseProduct(step);
    for (int axis = 0; axis < 3; ++axis) {
      const double d = std::abs(step[axis]);
      if (d <= 1e-12) continue;
      keep_least(d, triad.least_step[axis]);
      keep_least(d, lattice_[w][axis]);
    }
    ++triad.steps;
  }
  last_raw_[w] = vec(raw);
  has_last_raw_[w] = true;
}

std::optional<Window> RestDetector::evaluate(const CalibrationSnapshot& calibration) noexcept {
  Evidence e;
  for (std::size_t k = 0; k < 3; ++k) e.triad[k] = summarise(k);
  double temp_sum = 0.0;
  int temp_count = 0;
  for (const auto& q : quarters_) {
    temp_sum += q.temp_sum;
    temp_count += q.temp_count;
  }
  if (temp_count > 0) e.temp_degC = temp_sum / temp_count;
  judge_faults(e);
  const Refusal force = judge_force(e, calibration);
  if (force != Refusal::kNone) {
    last_refusal_ = force;
    anchor_.set = anchor_.set && force == Refusal::kTurning;
    return tell_faults(e);
  }
  const Refusal rate = judge_rate(e, calibration);
  last_refusal_ = rate;
  keep_anchor(e, rate);
  return make_window(e, rate, calibration);
}

}  // namespace stillpoint::calib

#include "pipeline/compensate_stage.h"

#include <Eigen/LU>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::pipeline {
namespace {

/// The effects are per mille of the reading; each pass gains three digits.
constexpr int kPasses = 4;
/// A difference quotient over a longer pause says nothing about the angular acceleration now.
constexpr double kLongestStep_s = 0.1;

/// y - H^-1 delta, so that H (y' - B) = H (y - B) - delta.
Array3 without(const Array3& reading, const TriadCalibration& live, const Vec3& delta) noexcept {
  const Mat3 H = mat(live.matrix);
  return array(Vec3(vec(reading) - H.inverse() * delta));
}

}  // namespace

Vec3 CompensateStage::true_force(const Vec3& u, double tau_K) const noexcept {
  const Vec3 offset = tau_K * (c_.acc_per_K + tau_K * c_.acc_per_K2);
  Vec3 f = u - offset;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Vec3 delta = c_.acc_asym.cwiseProduct(f.cwiseAbs()) + c_.acc_quad.cwiseProduct(f.cwiseAbs2()) +
                       c_.acc_cubic.cwiseProduct(f.cwiseAbs2()).cwiseProduct(f);
    f = u - offset - delta;
  }
  return f;
}

Vec3 CompensateStage::true_rate(const Vec3& u, const Vec3& force, double tau_K) const noexcept {
  const Vec3 offset = tau_K * (c_.gyr_per_K + tau_K * c_.gyr_per_K2) + c_.gyr_gsens * force;
  Vec3 w = u - offset;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Vec3 delta =
        c_.gyr_asym.cwiseProduct(w.cwiseAbs()) + c_.gyr_cubic.cwiseProduct(w.cwiseAbs2()).cwiseProduct(w);
    w = u - offset - delta;
  }
  return w;
}

Vec3 CompensateStage::lever(const Vec3& rate, std::int64_t t_ns) noexcept {
  const double dt_s = in_seconds(t_ns - last_rate_ns_);
  Vec3 acceleration = Vec3::Zero();
  if (has_rate_ && dt_s > 0.0 && dt_s < kLongestStep_s) acceleration = (rate - last_rate_) / dt_s;
  last_rate_ = rate;
  last_rate_ns_ = t_ns;
  has_rate_ = true;
  return acceleration.cross(c_.acc_lever_m) + rate.cross(rate.cross(c_.acc_lever_m));
}

StageStatus CompensateStage::process(const CalibratedSample& in, CalibratedSample& out) noexcept {
  out = in;
  if (!c_.any) return StageStatus::kOk;
  const double tau_K = in.temp_degC - c_.temp_ref_degC;
  Vec3 force = last_force_;
  if (in.holds(kAcc)) last_force_ = force = true_force(vec(in.acc_mps2), tau_K);
  if (in.holds(kGyr)) {
    const Vec3 rate = true_rate(vec(in.gyr_radps), force, tau_K);
    out.gyr_radps = array(rate);
    if (!c_.acc_lever_m.isZero()) force -= lever(rate, in.t_ns);
  }
  if (in.holds(kAcc)) out.acc_mps2 = array(force);
  if (in.holds(kMag)) {
    Vec3 m = vec(in.mag_uT) - tau_K * c_.mag_per_K;
    // A field fixed in the world turns in the body against the rate: m(t) = exp(-w tau) m(t - tau).
    if (c_.mag_delay_s > 0.0 && in.holds(kGyr)) m = exp_quat(Vec3(-c_.mag_delay_s * vec(out.gyr_radps))) * m;
    out.mag_uT = array(m);
  }
  if (c_.laws) take_out_laws(out);
  return StageStatus::kOk;
}

void CompensateStage::take_out_laws(CalibratedSample& sample) noexcept {
  last_read_.temp_degC = sample.temp_degC;
  if (sample.holds(kAcc)) last_read_.force = vec(sample.acc_mps2);
  if (sample.holds(kGyr)) last_read_.rate = vec(sample.gyr_radps);
  if (sample.holds(kMag)) last_read_.field = vec(sample.mag_uT);
  const Momentary now = without_laws(c_.laws, last_read_);
  if (sample.holds(kAcc)) sample.acc_mps2 = array(now.force);
  if (sample.holds(kGyr)) sample.gyr_radps = array(now.rate);
  if (sample.holds(kMag)) sample.mag_uT = array(now.field);
}

void CompensateStage::compensate(calib::Window& window, const CalibrationSnapshot& live) const noexcept {
  if (!c_.any) return;
  const bool has_rate = (window.has & kGyr) != 0, has_field = (window.has & kMag) != 0;
  const double tau_K = window.temp_degC - c_.temp_ref_degC;
  const Vec3 u_acc = live.acc.apply(window.acc_mps2, window.temp_degC);
  const Vec3 u_gyr = has_rate ? live.gyr.apply(window.gyr_radps, window.temp_degC) : Vec3(Vec3::Zero());
  const Vec3 u_mag = has_field ? live.mag.apply(window.mag_uT, window.temp_degC) : Vec3(Vec3::Zero());
  Momentary now{.force = true_force(u_acc, tau_K), .temp_degC = window.temp_degC};
  now.rate = true_rate(u_gyr, now.force, tau_K);
  now.field = u_mag - tau_K * c_.mag_per_K;
  now = without_laws(c_.laws, now);
  window.acc_mps2 = without(window.acc_mps2, live.acc, u_acc - now.force);
  if (has_rate) window.gyr_radps = without(window.gyr_radps, live.gyr, u_gyr - now.rate);
  if (has_field) window.mag_uT = without(window.mag_uT, live.mag, u_mag - now.field);
}

void CompensateStage::compensate(calib::FieldTurn& turn, const CalibrationSnapshot& live) const noexcept {
  if (!c_.any) return;
  const Vec3 of_temperature = (turn.temp_degC - c_.temp_ref_degC) * c_.mag_per_K;
  for (Array3* reading : {&turn.before_uT, &turn.after_uT}) {
    const Vec3 u = live.mag.apply(*reading, turn.temp_degC);
    Momentary now = last_read_;
    now.temp_degC = turn.temp_degC;
    now.field = u - of_temperature;
    *reading = without(*reading, live.mag, u - without_laws(c_.laws, now).field);
  }
}

}  // namespace stillpoint::pipeline

#include "pipeline/compensate_stage.h"

#include <Eigen/LU>

#include "core/so3.h"

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
  const double dt_s = 1e-9 * static_cast<double>(t_ns - last_rate_ns_);
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
  return StageStatus::kOk;
}

void CompensateStage::compensate(calib::Window& window, const CalibrationSnapshot& live) const noexcept {
  if (!c_.any) return;
  const double tau_K = window.temp_degC - c_.temp_ref_degC;
  const Vec3 u_acc = live.acc.apply(window.acc_mps2, window.temp_degC);
  const Vec3 force = true_force(u_acc, tau_K);
  window.acc_mps2 = without(window.acc_mps2, live.acc, u_acc - force);
  if ((window.has & kGyr) != 0) {
    const Vec3 u_gyr = live.gyr.apply(window.gyr_radps, window.temp_degC);
    window.gyr_radps = without(window.gyr_radps, live.gyr, u_gyr - true_rate(u_gyr, force, tau_K));
  }
  if ((window.has & kMag) != 0) window.mag_uT = without(window.mag_uT, live.mag, tau_K * c_.mag_per_K);
}

void CompensateStage::compensate(calib::FieldTurn& turn, const CalibrationSnapshot& live) const noexcept {
  if (!c_.any) return;
  const Vec3 delta = (turn.temp_degC - c_.temp_ref_degC) * c_.mag_per_K;
  turn.before_uT = without(turn.before_uT, live.mag, delta);
  turn.after_uT = without(turn.after_uT, live.mag, delta);
}

}  // namespace stillpoint::pipeline

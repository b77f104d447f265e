#include "diagnosis/trajectory/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib_online/online_calibrator.h"
#include "calib_online/rest_detector.h"
#include "diagnosis/certainty.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kFewest = 8;  // offsets along the recording, to speak of a course
constexpr double kLeastWay = 6.0;   // of the offset, in its own standard deviations
// Beyond the charge for three numbers: more than a law without a course needs, as a bias in motion is a filter's word.
constexpr double kAbstainOnCourse_nats = 10.0;
constexpr double kReplayed = 1e-5;  // rad/s/K: small beside what the calibration takes for an outlier

TriadCalibration factory(const sim::TriadConfig& t) {
  TriadCalibration c;
  mat(c.matrix) = t.matrix;
  vec(c.bias) = t.bias;
  return c;
}

Vec3 slope_of_levels(const Trajectory& t) {
  const auto n = static_cast<double>(t.t_s.size());
  Vec3 x = Vec3::Zero(), y = x, xx = x, xy = x;
  for (std::size_t i = 0; i < t.t_s.size(); ++i) x += t.per_K[i] / n, y += t.gyr_bias_radps[i] / n;
  for (std::size_t i = 0; i < t.t_s.size(); ++i) {
    const Vec3 d = t.per_K[i] - x;
    xx += d.cwiseAbs2(), xy += d.cwiseProduct(t.gyr_bias_radps[i] - y);
  }
  return xy.cwiseQuotient(xx.cwiseMax(1e-300));
}

Vec3 way(const Trajectory& t) {
  Vec3 low = t.gyr_bias_radps.front(), high = low;
  for (const Vec3& b : t.gyr_bias_radps) low = low.cwiseMin(b), high = high.cwiseMax(b);
  return high - low;
}

}  // namespace

Trajectory calibrate_along(const io::Recording& recording, const sim::SimulationConfig& simulation) {
  Trajectory out;
  if (!simulation.gyroscope || !simulation.accelerometer || recording.gyr_radps.empty() || recording.acc_mps2.empty())
    return out;
  CalibrationSnapshot start;
  start.acc = factory(*simulation.accelerometer), start.gyr = factory(*simulation.gyroscope);
  if (simulation.magnetometer) start.mag = factory(*simulation.magnetometer);
  calib::OnlineCalibrator calibrator({}, start), copy({}, start);
  calib::RestDetector detector;
  for (std::size_t row = 0; row < recording.size(); ++row) {
    const auto window = detector.push(recording.sample(row), calibrator.snapshot());
    if (!window) continue;
    calib::Window replayed = *window;
    const double tau_K = window->temp_degC - sim::kReferenceTemp_degC;
    vec(replayed.gyr_radps) += simulation.gyroscope->matrix.inverse() * Vec3::Constant(kReplayed * tau_K);
    copy.absorb(replayed);
    if (!calibrator.absorb(*window)) continue;
    const TriadCalibration& gyr = calibrator.snapshot().gyr;
    out.t_s.push_back(0.5e-9 * static_cast<double>(window->t_start_ns + window->t_end_ns) - recording.t_s(0));
    out.temp_degC.push_back(window->temp_degC);
    out.gyr_bias_radps.push_back(gyr.bias_at(window->temp_degC));
    out.per_K.push_back((copy.snapshot().gyr.bias_at(window->temp_degC) - out.gyr_bias_radps.back()) / kReplayed);
    out.sd_radps = mat(gyr.bias_covariance).diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  return out;
}

Followed follow_temperature(const Trajectory& t) {
  Followed f;
  Vec3 tt = Vec3::Zero(), tb = tt, bb = tt;
  for (std::size_t i = 1; i < t.t_s.size(); ++i) {
    const Vec3 dt = t.per_K[i] - t.per_K[i - 1], db = t.gyr_bias_radps[i] - t.gyr_bias_radps[i - 1];
    tt += dt.cwiseAbs2(), tb += dt.cwiseProduct(db), bb += db.cwiseAbs2();
  }
  const auto n = static_cast<double>(t.t_s.size()) - 1.0;
  if (n < 2.0 || tt.minCoeff() <= 0.0) return f;
  const Vec3 step = tb.cwiseQuotient(tt), left = (bb - step.cwiseProduct(tb)).cwiseMax(1e-12 * bb).array() + 1e-300;
  // Levels give the number, for its noise is least there; the increments' own estimate says how far a walk can pull it.
  f.k = slope_of_levels(t);
  f.sd = (left.cwiseQuotient(tt) / (n - 1.0) + 0.25 * (step - f.k).cwiseAbs2()).cwiseSqrt();
  for (int axis = 0; axis < 3; ++axis) f.gain_nats += 0.5 * n * std::log((bb[axis] + 1e-300) / left[axis]);
  return f;
}

std::vector<std::string> examine(const Trajectory& t, bool temperature_recorded) {
  if (t.t_s.size() < kFewest) return {};
  const Vec3 moved = way(t);
  int axis = 0;
  if (moved.cwiseQuotient(t.sd_radps.cwiseMax(1e-9)).maxCoeff(&axis) < kLeastWay) return {};
  const std::string course = fmt::format(
      "online calibration: the gyroscope's offset that it would learn moves by {:.2g} rad/s ({}-axis) along the "
      "recording",
      moved[axis], "xyz"[axis]);
  if (!temperature_recorded) return {course + "; whether after temperature is not known: record temp_degC"};
  const Followed f = follow_temperature(t);
  if (f.gain_nats < kAbstainOnCourse_nats + 3.0 * kNatsPerCoefficient) return {course + ", after no recorded quantity"};
  return {
      fmt::format("{}, after temperature: k = ({:.2g} +- {:.1g}, {:.2g} +- {:.1g}, {:.2g} +- {:.1g}) rad/s/K. It is "
                  "physics (gyr_temp_lin or a relative) that calibrated readings no longer show",
                  course, f.k[0], 1.96 * f.sd[0], f.k[1], 1.96 * f.sd[1], f.k[2], 1.96 * f.sd[2])};
}

}  // namespace stillpoint::diag

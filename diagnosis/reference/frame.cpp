#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/so3.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeast_rad = 5e-3;  // a smaller turn is a matrix that is not known better
constexpr double kAgreeShare = 0.1;  // of the turn: wrong matrices agree so well in one of a thousand cases
constexpr double kFloor_rad = 5e-4;
constexpr double kSharpShare = 0.25;  // two sensors at least must know it this well

struct Turn {
  Sensor sensor = kAcc;
  Vec3 phi = Vec3::Zero();
  double sd = 0.0;
};

Mat3 nearest_rotation(const Mat3& m) {
  const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/// The rotation in the map that brings this sensor's prediction to its reading.
std::optional<Turn> turn_of(const Signals& s, Sensor k) {
  if (!s.present[k] || s.residual[k].rows() == 0) return std::nullopt;
  const Target target = make_target(s, k);
  if (target.layout.used() < 500) return std::nullopt;
  const Fit fit = fit_profile(target, {});
  Mat3 map;
  double variance = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    map.row(axis) = fit.nuisance.segment<3>(4 * axis + 1);
    for (int j = 0; j < 3; ++j)
      if (j != axis) variance += 0.25 * fit.nuisance_covariance(4 * axis + 1 + j, 4 * axis + 1 + j);
  }
  // Where the sensor itself stands for the true vector, residual = u - C' u; else it is C v - v.
  const bool of_reference = s.exact_reference || k == kMag;
  const Mat3 C = of_reference ? Mat3(Mat3::Identity() + map) : Mat3((Mat3::Identity() - map).inverse());
  if (!C.allFinite()) return std::nullopt;
  const Quat q(nearest_rotation(C));
  return Turn{k, -log_quat(q), std::sqrt(std::max(variance, 0.0))};
}

double rms(const Series3& x, const Mask& muted) {
  double sum = 0.0, count = 1e-9;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (!muted[static_cast<std::size_t>(i)]) sum += x.row(i).squaredNorm() / 3.0, count += 1.0;
  return std::sqrt(sum / count);
}

}  // namespace

void turn_into_sensor_frame(Signals& s, const Vec3& phi_rad) {
  const Mat3 C = exp_so3(-phi_rad);
  const auto turn = [&C](Series3& x) { x = (x * C.transpose()).eval(); };
  for (int k = 0; k < kSensors; ++k) {
    if (s.predicted[k].rows() == 0) continue;
    s.residual[k] += s.predicted[k];  // what was taken out of it stays out
    turn(s.predicted[k]);
    s.residual[k] -= s.predicted[k];
    if (s.exact_reference || k == kMag || !s.present[k]) turn(s.vector[k]);
  }
  for (Series3& axis : s.world_axis) turn(axis);
  if (s.exact_reference || !s.present[kGyr]) turn(s.rate), turn(s.rate_dot);
}

void find_frame(Signals& s, const sim::SimulationConfig& given, Answer& answer) {
  if (contains(given.effects, "ref_frame")) return;
  std::vector<Turn> turns;
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (const auto t = turn_of(s, k)) turns.push_back(*t);
  Vec3 sum = Vec3::Zero();
  double weight = 0.0;
  for (const Turn& t : turns) {
    const double w = 1.0 / (t.sd * t.sd + kFloor_rad * kFloor_rad);
    sum += w * t.phi, weight += w;
  }
  if (turns.size() < 2) return;
  const Vec3 phi = sum / weight;
  const double size = phi.norm();
  if (size < kLeast_rad) return;
  const auto agrees = [&](const Turn& t) {
    return (t.phi - phi).norm() < kAgreeShare * size + 4.0 * t.sd + kFloor_rad;
  };
  const auto sharp = [&](const Turn& t) { return 4.0 * t.sd < kSharpShare * size; };
  if (!std::all_of(turns.begin(), turns.end(), agrees) || std::count_if(turns.begin(), turns.end(), sharp) < 2) return;

  Finding f;
  f.effect = "ref_frame";
  f.equation = "true = exp(phi)' true of the reference's body, in all sensors";
  f.driver = "attitude and rate";
  f.regime = "all the time";
  f.interval_s = {0.0, s.duration_s()};
  double gain = 0.0;
  for (const Turn& t : turns) {
    gain += 0.5 * phi.squaredNorm() / std::max(t.sd * t.sd, 1e-16);
    for (const char* axis : kAxisName) f.channels.push_back(std::string(kSensorName[t.sensor]) + "_" + axis);
  }
  // As far as the sensors disagree, the turn is not known.
  double disagreement = 0.0;
  for (const Turn& t : turns) disagreement = std::max(disagreement, (t.phi - phi).norm());
  const double half = std::max(1.96 / std::sqrt(weight), disagreement);
  for (int a = 0; a < 3; ++a)
    f.parameters.push_back(
        {std::string("phi_") + kAxisName[static_cast<std::size_t>(a)], phi[a], {phi[a] - half, phi[a] + half}, "rad"});
  const Sensor strongest =
      std::min_element(turns.begin(), turns.end(), [](const Turn& a, const Turn& b) { return a.sd < b.sd; })->sensor;
  f.held_out.unit = kSensorUnit[strongest];
  f.held_out.rms_before = rms(s.residual[strongest], s.muted[strongest]);
  turn_into_sensor_frame(s, phi);
  f.held_out.rms_after = rms(s.residual[strongest], s.muted[strongest]);
  f.held_out.noise_floor = s.noise_sd[strongest];
  f.held_out.gain_nats = gain;
  f.p_value = chi_square_tail(2.0 * gain, 3.0);
  f.confidence = 0.99;
  f.runner_up_effect = "wrong matrices";
  f.runner_up_why_rejected = "those of all sensors would have to be turned by the same angles by chance";
  f.decided_by = "a turn of the mount by a known angle; the sensor's own axes do not follow it";
  answer.diagnosis.findings.push_back(std::move(f));
  answer.effects.push_back(
      {.id = "ref_frame", .parameters = {{"phi_rad", {phi[0], phi[1], phi[2]}}}, .axes = {}, .window_s = {}});
}

}  // namespace stillpoint::diag

#include <algorithm>
#include <cmath>

#include "core/directions.h"
#include "core/so3.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/fitted_matrix.h"

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

/// The rotation in the map that brings this sensor's prediction to its reading.
std::optional<Turn> turn_of(const Signals& s, Sensor k) {
  if (!s.compared(k)) return std::nullopt;
  const Target target = make_target(s, k);
  if (target.layout.used() < 500) return std::nullopt;
  const Fit fit = fit_profile(target, {});
  const Mat3 C = undoing(s, k, fitted_matrix(fit)).inverse();
  if (is_no_matrix(C)) return std::nullopt;
  double variance = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    for (int j = 0; j < 3; ++j)
      if (j != axis) variance += 0.25 * fit.nuisance_covariance(4 * axis + 1 + j, 4 * axis + 1 + j);
  const Quat q(nearest_orthogonal(C));
  return Turn{k, -log_quat(q), std::sqrt(std::max(variance, 0.0))};
}

double rms(const Series3& x, const Mask& muted) {
  double sum = 0.0, count = 1e-9;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (!muted[static_cast<std::size_t>(i)]) sum += x.row(i).squaredNorm() / 3.0, count += 1.0;
  return std::sqrt(sum / count);
}

/// One rotation for all sensors, and what it is known by.
struct CommonTurn {
  Vec3 phi = Vec3::Zero();
  double half_rad = 0.0;  ///< of its 95 % interval
  double gain_nats = 0.0;
  Sensor sharpest = kAcc;
};

/// None where two sensors at least do not know it well, or one disagrees.
std::optional<CommonTurn> common_turn(const std::vector<Turn>& turns) {
  if (turns.size() < 2) return std::nullopt;
  CommonTurn out;
  double weight = 0.0;
  for (const Turn& t : turns) {
    const double w = 1.0 / (t.sd * t.sd + kFloor_rad * kFloor_rad);
    out.phi += w * t.phi, weight += w;
  }
  out.phi /= weight;
  const double size = out.phi.norm();
  if (size < kLeast_rad) return std::nullopt;
  const auto agrees = [&](const Turn& t) {
    return (t.phi - out.phi).norm() < kAgreeShare * size + 4.0 * t.sd + kFloor_rad;
  };
  const auto sharp = [&](const Turn& t) { return 4.0 * t.sd < kSharpShare * size; };
  if (!std::all_of(turns.begin(), turns.end(), agrees) || std::count_if(turns.begin(), turns.end(), sharp) < 2)
    return std::nullopt;
  out.half_rad = 1.96 / std::sqrt(weight);
  for (const Turn& t : turns) {
    out.half_rad = std::max(out.half_rad, (t.phi - out.phi).norm());  // as far as they disagree, it is not known
    out.gain_nats += 0.5 * size * size / std::max(t.sd * t.sd, 1e-16);
  }
  out.sharpest =
      std::min_element(turns.begin(), turns.end(), [](const Turn& a, const Turn& b) { return a.sd < b.sd; })->sensor;
  return out;
}

Finding finding_of(const Signals& s, const std::vector<Turn>& turns, const CommonTurn& common) {
  Finding f;
  f.effect = "ref_frame";
  f.equation = "true = exp(phi)' true of the reference's body, in all sensors";
  f.driver = "attitude and rate";
  f.regime = "all the time";
  f.interval_s = {0.0, s.duration_s()};
  for (const Turn& t : turns)
    for (const char* axis : kAxisName) f.channels.push_back(std::string(kSensorName[t.sensor]) + "_" + axis);
  for (int a = 0; a < 3; ++a) {
    const double x = common.phi[a];
    f.parameters.push_back({std::string("phi_") + kAxisName[static_cast<std::size_t>(a)],
                            x,
                            {x - common.half_rad, x + common.half_rad},
                            "rad"});
  }
  f.held_out.unit = kSensorUnit[common.sharpest];
  f.held_out.noise_floor = s.noise_sd[common.sharpest];
  f.held_out.gain_nats = common.gain_nats;
  f.p_value = chi_square_tail(2.0 * common.gain_nats, 3.0);
  f.runner_up_effect = "wrong matrices";
  f.runner_up_why_rejected = "those of all sensors would have to be turned by the same angles by chance";
  f.decided_by = "a turn of the mount by a known angle; the sensor's own axes do not follow it";
  return f;
}

}  // namespace

void turn_into_sensor_frame(Signals& s, const Series3& phi_rad) {
  const auto turn = [&phi_rad](Series3& x) {
    for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = x.row(i) * exp_so3(phi_rad.row(i).transpose());
  };
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (s.predicted[k].rows() == 0) continue;
    s.residual[k] += s.predicted[k];  // what was taken out of it stays out
    turn(s.predicted[k]);
    s.residual[k] -= s.predicted[k];
    if (!vector_is_reading(s, k)) turn(s.vector[k]);
  }
  for (Series3& axis : s.world_axis) turn(axis);
  if (!vector_is_reading(s, kGyr)) turn(s.rate), turn(s.rate_dot);
}

void turn_into_sensor_frame(Signals& s, const Vec3& phi_rad) {
  turn_into_sensor_frame(s, Series3(phi_rad.transpose().replicate(s.n, 1)));
}

void find_frame(Signals& s, const sim::SimulationConfig& given, Answer& answer) {
  if (contains(given.effects, "ref_frame")) return;
  std::vector<Turn> turns;
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (const auto t = turn_of(s, k)) turns.push_back(*t);
  const auto common = common_turn(turns);
  if (!common) return;
  const Sensor k = common->sharpest;
  Finding f = finding_of(s, turns, *common);
  f.held_out.rms_before = rms(s.residual[k], s.muted[k]);
  turn_into_sensor_frame(s, common->phi);
  f.held_out.rms_after = rms(s.residual[k], s.muted[k]);
  answer.diagnosis.findings.push_back(std::move(f));
  const Vec3& phi = common->phi;
  answer.effects.push_back(
      {.id = "ref_frame", .parameters = {{"phi_rad", {phi[0], phi[1], phi[2]}}}, .axes = {}, .window_s = {}});
}

}  // namespace stillpoint::diag

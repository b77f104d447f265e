#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "diagnosis/certainty.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/rest.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeastNats = 30.0;       // more than the least a law needs: its noise model is the simpler one
constexpr double kWitness = 3.0;          // nats with which a sensor says so itself
constexpr double kContradiction = -5.0;   // nats of one sensor that speak against the others
constexpr double kLeastOfExpected = 0.3;  // of the gain that a common clock would give: less is one sensor's own noise
constexpr double kLeastSlope = 0.5;       // of a millisecond's change over the noise: slower rows say nothing
constexpr double kAcross_s = 1.0;         // noise across the derivative is averaged over twice this
constexpr double kWhite = 0.3;            // correlation of neighbours: a delay or a lost sample lasts
constexpr double kSlowest_s = 1e-6, kFastest_s = 2e-2;
constexpr int kGrid = 80;

/// One sensor's rows in motion, in units of its noise.
struct Rows {
  Sensor sensor = kAcc;
  std::vector<Eigen::Index> at;
  std::vector<double> along, slope, noise;  ///< residual along the derivative; size of the derivative per s; variance
};

/// The residual without what a bias, a matrix, a delay and smooth curves explain.
Series3 rough(const Signals& s, Sensor k, const Series3& slope) {
  const WalkBasis walk = walk_basis(s);
  const Eigen::Index terms = std::min<Eigen::Index>(walk->cols(), 16);
  const Series3& v = s.vector[k];
  Eigen::MatrixXd design(s.n, 10 + terms);
  design << Eigen::VectorXd::Ones(s.n), v, slope, v.cwiseAbs2(), walk->leftCols(terms);
  Series3 y = s.residual[k];
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (s.muted[k][static_cast<std::size_t>(i)]) design.row(i).setZero(), y.row(i).setZero();
  const Eigen::VectorXd scale = design.colwise().norm().cwiseMax(1e-12);
  design = design * scale.cwiseInverse().asDiagonal();
  return y - design * design.colPivHouseholderQr().solve(Eigen::MatrixXd(y));
}

/// Variance of each axis in the slower half of its rows, where jitter adds least: axes need not be equally noisy.
Vec3 quiet_variance(const Series3& left, const Series3& slope, const Mask& muted) {
  Vec3 out = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::pair<double, double>> rows;  // size of the derivative, square of the residual
    for (Eigen::Index i = 0; i < left.rows(); ++i)
      if (!muted[static_cast<std::size_t>(i)]) rows.emplace_back(std::abs(slope(i, axis)), std::pow(left(i, axis), 2));
    const auto half = static_cast<std::ptrdiff_t>(rows.size() / 2);
    if (half == 0) continue;
    std::nth_element(rows.begin(), rows.begin() + half, rows.end());
    for (auto row = rows.begin(); row != rows.begin() + half; ++row)
      out[axis] += row->second / static_cast<double>(half);
  }
  return out;
}

Rows rows_of(const Signals& s, Sensor k) {
  Rows rows;
  rows.sensor = k;
  const Series3 slope = at_rest_zero(s, derivative(s.vector[k], s.rows));
  const Series3 left = rough(s, k, slope);
  const Vec3 quiet2 = quiet_variance(left, slope, s.muted[k]);
  Series across = Series::Zero(s.n), counted = across, along = across, quiet_along = across;
  for (Eigen::Index i = 0; i < s.n; ++i) {
    const Vec3 d = slope.row(i), v = s.vector[k].row(i), r = left.row(i);
    if (s.muted[k][static_cast<std::size_t>(i)] || 1e-3 * d.norm() < 1e-2 * kLeastSlope * s.noise_sd[k]) continue;
    // Errors of the orientation turn the vector: they are alike along the derivative and across both.
    const Vec3 n = v.cross(d);
    if (!(n.norm() > 1e-9)) continue;
    const double quiet_across = n.cwiseAbs2().dot(quiet2);
    if (!(quiet_across > 0.0)) continue;
    across[i] = std::pow(r.dot(n), 2) / quiet_across, along[i] = r.dot(d) / d.norm(), counted[i] = 1.0;
    quiet_along[i] = d.cwiseAbs2().dot(quiet2) / d.squaredNorm();
  }
  const auto half = static_cast<Eigen::Index>(kAcross_s / s.dt_s);
  const Series mean = moving_mean(across, half).cwiseQuotient(moving_mean(counted, half).cwiseMax(1e-9));
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (counted[i] == 0.0 || !(mean[i] * quiet_along[i] > 0.0)) continue;
    rows.at.push_back(i);
    rows.along.push_back(along[i]);
    rows.slope.push_back(slope.row(i).norm());
    rows.noise.push_back(mean[i] * quiet_along[i]);
  }
  return rows;
}

double gain_of(const Rows& rows, double sd_s) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const double v = rows.noise[i], w = v + std::pow(sd_s * rows.slope[i], 2), y2 = rows.along[i] * rows.along[i];
    sum -= 0.5 * (std::log(w / v) + y2 / w - y2 / v);
  }
  return sum;
}

/// What a jitter of this size would gain in these rows.
double expected_gain(const Rows& rows, double sd_s) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const double ratio = 1.0 + std::pow(sd_s * rows.slope[i], 2) / rows.noise[i];
    sum += 0.5 * (ratio - 1.0 - std::log(ratio));
  }
  return sum;
}

/// Covariance of neighbours over the variance that jitter adds.
double memory_of(const Rows& rows) {
  double pairs = 0.0, excess = 0.0;
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const double weight = 1.0 / rows.noise[i], y = rows.along[i];
    excess += weight * (y * y - rows.noise[i]);
    if (i > 0 && rows.at[i] == rows.at[i - 1] + 1) pairs += weight * y * rows.along[i - 1];
  }
  return excess > 0 ? pairs / excess : 1.0;
}

struct Jitter {
  double sd_s = 0.0, half_s = 0.0, gain_nats = 0.0;
};

double total(const std::vector<Rows>& sensors, double sd_s) {
  double sum = 0.0;
  for (const Rows& r : sensors) sum += gain_of(r, sd_s);
  return sum;
}

Jitter most_likely(const std::vector<Rows>& sensors) {
  Jitter best;
  const double step = std::log(kFastest_s / kSlowest_s) / kGrid;
  for (int i = 0; i <= kGrid; ++i)
    for (const double sd = kSlowest_s * std::exp(step * i); const double gain : {total(sensors, sd)})
      if (gain > best.gain_nats) best.sd_s = sd, best.gain_nats = gain;
  if (best.sd_s == 0.0) return best;
  const auto at = [&](double x) { return total(sensors, best.sd_s * std::exp(x)); };
  const double low = at(-step), high = at(step), bend = low - 2.0 * best.gain_nats + high;
  if (bend >= 0.0) return best;
  const double shift = std::clamp(0.5 * step * (low - high) / bend, -step, step);
  best.sd_s *= std::exp(shift);
  best.half_s = 1.96 * best.sd_s * step / std::sqrt(-bend);
  best.gain_nats = total(sensors, best.sd_s);
  return best;
}

/// The time of each row, as all channels tell it together, and its prior spread; what it explains is taken out.
void set_right(Signals& s, const std::vector<Rows>& sensors, double sd_s) {
  Series information = Series::Constant(s.n, 1.0 / (sd_s * sd_s)), evidence = Series::Zero(s.n);
  for (const Rows& r : sensors)
    for (std::size_t i = 0; i < r.at.size(); ++i) {
      information[r.at[i]] += r.slope[i] * r.slope[i] / r.noise[i];
      evidence[r.at[i]] += r.slope[i] * r.along[i] / r.noise[i];
    }
  const Series late_s = evidence.cwiseQuotient(information);
  for (const Rows& r : sensors) {
    const Series3& v = s.vector[r.sensor];
    const Series3 bend = 0.5 * at_rest_zero(s, second_derivative(v, s.rows));
    s.residual[r.sensor] -=
        late_s.asDiagonal() * at_rest_zero(s, derivative(v, s.rows)) + late_s.cwiseAbs2().asDiagonal() * bend;
  }
}

Finding finding_of(const Signals& s, const std::vector<Rows>& sensors, const Jitter& jitter) {
  Finding f;
  f.effect = "sys_jitter";
  f.equation = "u(t) = true(t + d), d white";
  f.driver = "derivatives of the true vectors";
  f.regime = "in motion, at random from row to row; the faster, the more";
  f.interval_s = {0.0, s.duration_s()};
  double largest = 0.0;
  for (const Rows& r : sensors) {
    const double gain = gain_of(r, jitter.sd_s);
    if (gain > 3.0)
      for (const char* axis : kAxisName) f.channels.push_back(std::string(kSensorName[r.sensor]) + "_" + axis);
    if (gain <= largest) continue;
    largest = gain;
    double before = 0.0, floor = 0.0;
    for (std::size_t i = 0; i < r.at.size(); ++i) before += r.along[i] * r.along[i], floor += r.noise[i];
    const double n = std::max<double>(static_cast<double>(r.at.size()), 1.0);
    f.held_out.rms_before = std::sqrt(before / n);
    f.held_out.rms_after = f.held_out.noise_floor = std::sqrt(floor / n);
    f.held_out.unit = kSensorUnit[r.sensor];
  }
  f.parameters = {{"sd", jitter.sd_s, {jitter.sd_s - jitter.half_s, jitter.sd_s + jitter.half_s}, "s"}};
  f.held_out.gain_nats = jitter.gain_nats;
  f.p_value = chi_square_tail(2.0 * jitter.gain_nats, 1.0);
  f.confidence = confidence_of(jitter.gain_nats - kLeastNats);
  f.runner_up_effect = "noise that grows with motion";
  f.runner_up_why_rejected = "it would lie across the derivative as well as along it";
  f.decided_by = "time stamps taken by the sensor itself (data ready) beside those of the host";
  return f;
}

}  // namespace

void find_jitter(Signals& s, const sim::SimulationConfig& given, Answer& answer) {
  std::vector<Rows> sensors;
  for (const Sensor k : {kAcc, kGyr, kMag})
    if (s.present[k] && s.residual[k].rows() > 0 && s.n > 200)
      if (Rows r = rows_of(s, k); r.at.size() > 200) sensors.push_back(std::move(r));
  const Jitter jitter = most_likely(sensors);
  // The field of a place may jump by itself: the magnetometer alone is no witness of the clock.
  double witnessed = 0.0;
  int inertial = 0, witnesses = 0;
  for (const Rows& r : sensors) {
    if (r.sensor == kMag) continue;
    const double gain = gain_of(r, jitter.sd_s);
    witnessed += gain, ++inertial, witnesses += gain > kWitness;
  }
  // One sensor's noise may grow with its motion by itself.
  if (witnessed < kLeastNats || witnesses < inertial) return;
  for (const Rows& r : sensors) {
    const double gain = gain_of(r, jitter.sd_s);
    // One clock for all; a magnetometer often has one of its own.
    const double due = r.sensor == kMag ? 0.0 : kLeastOfExpected * expected_gain(r, jitter.sd_s);
    if (gain < kContradiction + due || (gain > 3.0 && std::abs(memory_of(r)) > kWhite)) return;
  }
  if (!contains(given.effects, "sys_jitter")) {
    answer.diagnosis.findings.push_back(finding_of(s, sensors, jitter));
    answer.effects.push_back({.id = "sys_jitter", .parameters = {{"sd_s", {jitter.sd_s}}}, .axes = {}, .window_s = {}});
  }
  set_right(s, sensors, jitter.sd_s);
}

}  // namespace stillpoint::diag

#include "diagnosis/reference/signals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/so3.h"
#include "diagnosis/reference/band_limit.h"
#include "diagnosis/reference/decimals.h"
#include "diagnosis/reference/response.h"
#include "diagnosis/reference/rest.h"
#include "diagnosis/sanity/readings.h"

namespace stillpoint::diag {
namespace {

constexpr double kExactJitter_rad = 2e-6;  // a reference quieter than this is arithmetic, not a camera
constexpr double kMotionOverNoise =
    60.0;  // power; the noise in a driver then costs a candidate less than it costs to be named
constexpr double kSeenOverNoise = 0.05;  // an error of the reference that a sensor of this noise would show
constexpr double kVibration_Hz = 15.0;
constexpr double kEnds_s = 0.6;  // where differences are one-sided and filters lean on the mirror image

Eigen::Matrix<double, Eigen::Dynamic, 4> orientation_of(const io::Recording& recording) {
  const auto n = static_cast<Eigen::Index>(recording.size());
  Eigen::Matrix<double, Eigen::Dynamic, 4> q(n, 4);
  Eigen::Vector4d last(1, 0, 0, 0);
  std::vector<Eigen::Vector4d> continuous = recording.ref_q_world_body;
  for (auto& value : continuous) {
    if (!value.allFinite() || value.norm() < 0.5) {
      value.setConstant(io::kMissing);
      continue;
    }
    value.normalize();
    if (value.dot(last) < 0) value = -value;  // q and -q are one rotation; differences need one branch
    last = value;
  }
  for (int c = 0; c < 4; ++c)
    q.col(c) = filled(n, [&](Eigen::Index i) { return continuous[static_cast<std::size_t>(i)][c]; });
  return q;
}

/// omega = 2 q* dq/dt, exact for any rotation; differences of logarithms would miss the coning part.
Series3 rate_from(const Eigen::Matrix<double, Eigen::Dynamic, 4>& q, double dt_s) {
  Series3 vector_part = q.rightCols<3>();
  Series3 scalar_part = Series3::Zero(q.rows(), 3);
  scalar_part.col(0) = q.col(0);
  const Series3 dv = derivative(vector_part, dt_s), dw = derivative(scalar_part, dt_s);
  Series3 rate(q.rows(), 3);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Vec3 v = q.row(i).tail<3>(), d = dv.row(i);
    rate.row(i) = 2.0 * (q(i, 0) * d - dw(i, 0) * v - v.cross(d));
  }
  return rate;
}

double rest_jitter(const Signals& s, const Series3& rate) {
  double sum = 0.0;
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (!s.rest[static_cast<std::size_t>(i)]) continue;
    sum += rate.row(i).squaredNorm() / 3.0;
    ++count;
  }
  return count == 0 ? -1.0 : std::sqrt(sum / static_cast<double>(count));
}

/// The same without a rest: what eighth differences show is noise, motion leaves a millionth of itself in them.
double jitter_without_rest(const Eigen::Matrix<double, Eigen::Dynamic, 4>& q) {
  constexpr int kTimes = 8;
  constexpr double kGain = 113.4;  // of white noise: the root of the sum of the squared binomials of 8
  constexpr double kMedianOverSd = 0.6745;
  Eigen::MatrixXd d = q.rightCols<3>();
  for (int k = 0; k < kTimes && d.rows() > 1; ++k) d = (d.bottomRows(d.rows() - 1) - d.topRows(d.rows() - 1)).eval();
  return 2.0 * quantile(d.cwiseAbs().rowwise().mean(), 0.5) / (kGain * kMedianOverSd);
}

void mute_ends(Mask& mask, Eigen::Index n, Eigen::Index ends) {
  for (Eigen::Index i = 0; i < std::min(ends, n); ++i) {
    mask[static_cast<std::size_t>(i)] = 1;
    mask[static_cast<std::size_t>(n - 1 - i)] = 1;
  }
}

/// Where the reference was lost, and beside it as far as its differences reach, nothing can be compared.
void mute_lost_reference(Signals& s, const io::Recording& recording) {
  constexpr std::ptrdiff_t kReach = kStencilReach + 1;
  const auto n = static_cast<std::ptrdiff_t>(s.n);
  std::ptrdiff_t until = 0;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool there =
        recording.ref_q_world_body[at].allFinite() && (!s.has_position || recording.ref_position_m[at].allFinite());
    if (there) continue;
    for (std::ptrdiff_t k = std::max(until, i - kReach); k <= std::min(i + kReach, n - 1); ++k)
      for (Mask& muted : s.muted)
        if (!muted.empty()) muted[static_cast<std::size_t>(k)] = 1;
    until = i + kReach + 1;
  }
}

/// A vibration near half the rate of the reference cannot be differentiated: where what is left of the error reaches
/// the sensor's noise, nothing can be compared. A noisy reference carries its noise there, and no error is seen.
void mute_unresolved(Signals& s, const std::array<Series, 2>& error) {
  for (const Sensor k : {kAcc, kGyr}) {
    if (!s.present[k] || error[k].size() == 0) continue;
    const Series near = moving_mean(error[k].cwiseAbs2(), kStencilReach).cwiseSqrt();
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < s.n; ++i)
      if (std::uint8_t& muted = s.muted[k][static_cast<std::size_t>(i)];
          near[i] > kSeenOverNoise * s.noise_sd[k] && !muted)
        muted = 1, ++count;
    const double share = static_cast<double>(count) / static_cast<double>(s.n);
    if (share < 0.005) continue;
    s.present[k] = share < 0.9;
    s.notices.push_back(fmt::format(
        "{}: in {:.0f} % of the rows the body vibrates too fast for a reference of {:.0f} rows a second; {}. Record "
        "the "
        "reference at four times the frequency of the vibration, or more",
        kSensorName[k], 100.0 * share, 1.0 / s.dt_s, s.present[k] ? "they are left out" : "the sensor is left out"));
  }
}

/// A reference of few decimals is a noisy one, although it is perfectly still at rest.
bool rounding_shows(const Signals& s, const io::Recording& recording) {
  const RoundingNoise noise = rounding_noise(recording, s.dt_s);
  return (s.present[kGyr] && noise.rate_radps > kSeenOverNoise * s.noise_sd[kGyr]) ||
         (s.present[kAcc] && noise.acceleration_mps2 > kSeenOverNoise * s.noise_sd[kAcc]);
}

void read_triads(Signals& s, const io::Recording& recording, const sim::SimulationConfig& simulation,
                 const std::array<Mask, kSensors>& muted) {
  const std::array<const std::vector<Vec3>*, kSensors> raw{&recording.acc_mps2, &recording.gyr_radps,
                                                           &recording.mag_uT};
  const std::array<const std::optional<sim::TriadConfig>*, kSensors> triads{
      &simulation.accelerometer, &simulation.gyroscope, &simulation.magnetometer};
  for (int k = 0; k < kSensors; ++k) {
    if (raw[k]->empty() || !*triads[k]) continue;
    const sim::TriadConfig& triad = **triads[k];
    s.muted[k] = muted[k].size() == raw[k]->size() ? muted[k] : Mask(raw[k]->size(), 0);
    std::size_t missing = 0;
    for (std::size_t i = 0; i < raw[k]->size(); ++i)
      if (!(*raw[k])[i].allFinite()) s.muted[k][i] = 1, ++missing;
    if (missing == raw[k]->size()) continue;
    const Series3 y = filled3(*raw[k]);
    s.reading[k] = (y.rowwise() - triad.bias.transpose()) * triad.matrix.transpose();
    s.noise_sd[k] = triad.noise_sd;
    s.triad[k] = triad;
    s.present[k] = true;
  }
}

/// Driver of rectification, where there is a vibration that could be rectified: fast power above that of the noise.
Series3 vibration_of(const Signals& s) {
  constexpr double kOverNoise = 4.0, kAverage_s = 0.5;
  const Series power = fast_power(s.reading[kAcc], s.dt_s, kVibration_Hz).rowwise().sum();
  const double noise = std::max(3.0 * s.noise_sd[kAcc] * s.noise_sd[kAcc], quantile(power, 0.05));
  if (quantile(power, 0.9) < kOverNoise * noise) return {};
  return rectified_power(s.reading[kAcc], s.dt_s, kAverage_s);
}

void read_drivers(Signals& s, const io::Recording& recording) {
  const auto read = [&](const std::vector<double>& column, double offset) {
    if (column.empty()) return Series();
    const bool any = std::any_of(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
    if (!any) return Series();
    Series x = filled(s.n, [&](Eigen::Index i) { return column[static_cast<std::size_t>(i)] - offset; });
    return x;
  };
  s.temperature_K = read(recording.temp_degC, kReferenceTemperature_degC);
  if (s.temperature_K.size()) s.temperature_K = moving_mean(s.temperature_K, static_cast<Eigen::Index>(0.5 / s.dt_s));
  s.current_A = read(recording.current_A, 0.0);
  s.voltage_V = read(recording.supply_V, 0.0);
}

void predict(Signals& s, const io::Recording& recording) {
  const auto q = orientation_of(recording);
  Series3 rate = rate_from(q, s.dt_s);
  Series3 acceleration = Series3::Zero(s.n, 3), velocity;
  if (s.has_position) {
    const Series3 p = filled3(recording.ref_position_m);
    s.position_m = p.rowwise() - p.colwise().mean();
    velocity = derivative(p, s.dt_s);
    acceleration = second_derivative(p, s.dt_s);
  }
  const double own_jitter = jitter_without_rest(q);
  wake_where_reference_moves(s.rest, rate, velocity, s.dt_s, own_jitter < kExactJitter_rad);
  const double jitter = rest_jitter(s, rate);
  s.has_rest = jitter >= 0.0;
  s.reference_jitter_rad = s.has_rest ? jitter * s.dt_s : own_jitter;
  s.exact_reference = s.reference_jitter_rad < kExactJitter_rad && !rounding_shows(s, recording);
  if (s.exact_reference)
    mute_unresolved(s, {s.has_position ? second_derivative_error(filled3(recording.ref_position_m), s.dt_s) : Series(),
                        2.0 * derivative_error(q.rightCols<3>(), s.dt_s)});
  for (auto& axis : s.world_axis) axis.resize(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (s.rest[static_cast<std::size_t>(i)]) {  // nothing moves at rest: what the reference shows there is its noise
      rate.row(i).setZero();
      acceleration.row(i).setZero();
    }
    const Mat3 R = Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)).normalized().toRotationMatrix();
    for (int a = 0; a < 3; ++a) s.world_axis[static_cast<std::size_t>(a)].row(i) = R.row(a);
  }
  const auto to_body = [&](const Series3& world) {
    Series3 body = Series3::Zero(s.n, 3);
    for (int a = 0; a < 3; ++a) body += world.col(a).asDiagonal() * s.world_axis[static_cast<std::size_t>(a)];
    return body;
  };
  acceleration.col(2).array() += s.gravity_mps2;
  s.predicted[kAcc] = to_body(acceleration);
  s.predicted[kGyr] = rate;
  s.predicted[kMag] = to_body(s.field_world_uT.transpose().replicate(s.n, 1));
}

/// At rest nothing moves: there the vector is one value a rest, or the sensor's own noise would stand in residual and
/// driver alike.
void hold_at_rest(Signals& s) {
  const auto hold = [](auto rows) { rows.rowwise() = rows.colwise().mean().eval(); };
  for (Eigen::Index begin = 0; begin < s.n; ++begin) {
    Eigen::Index end = begin;
    while (end < s.n && s.rest[static_cast<std::size_t>(end)]) ++end;
    if (end == begin) continue;
    for (Series3& v : s.vector) hold(v.middleRows(begin, end - begin));
    for (Series3& v : s.world_axis) hold(v.middleRows(begin, end - begin));
    s.vector[kGyr].middleRows(begin, end - begin).setZero();
    begin = end;
  }
}

/// Which signal stands for the true vector: a noiseless reference; else the sensor itself, which is quieter than a
/// differentiated camera, in the band where things move.
void choose_vectors(Signals& s) {
  const double highest = std::min(kMotionBand_Hz, 0.2 / s.dt_s);
  const auto limited = [&](const Series3& x) {
    return apply_response(x, s.dt_s, low_pass(motion_band_hz(x, s.rest, s.dt_s, kMotionOverNoise, 1.5, highest)));
  };
  if (!s.exact_reference) {
    for (Series3& axis : s.world_axis) axis = limited(axis);
    if (s.has_position) s.position_m = limited(s.position_m);
  }
  for (int k = 0; k < kSensors; ++k) {
    const bool predicted = s.exact_reference || !s.present[k] || k == kMag;
    s.vector[k] = predicted ? s.predicted[k] : s.reading[k];
    if (!s.exact_reference && k != kMag) s.vector[k] = limited(s.vector[k]);
  }
  if (!s.exact_reference) {
    hold_at_rest(s);
    // Of the same turns as the world's axes: where the two differ by their noise only, a field of the world that is
    // nothing but that noise would be fitted to it.
    s.vector[kMag].setZero();
    for (int a = 0; a < 3; ++a) s.vector[kMag] += s.field_world_uT[a] * s.world_axis[static_cast<std::size_t>(a)];
  }
  s.rate = s.vector[kGyr];
  s.rate_dot = derivative(s.rate, s.dt_s);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (!s.rest[static_cast<std::size_t>(i)]) continue;
    s.rate.row(i).setZero();
    s.rate_dot.row(i).setZero();
  }
}

}  // namespace

Result<Signals> make_signals(const io::Recording& recording, const sim::SimulationConfig& simulation,
                             const std::array<Mask, kSensors>& muted) {
  Signals s;
  s.n = static_cast<Eigen::Index>(recording.size());
  s.dt_s = even_step_s(recording);
  s.start_s = recording.t_s(0);
  s.t_s = Series(s.n);
  for (Eigen::Index i = 0; i < s.n; ++i) s.t_s[i] = recording.t_s(static_cast<std::size_t>(i)) - s.start_s;
  s.gravity_mps2 = simulation.gravity_mps2;
  s.latitude_rad = simulation.environment.latitude_rad;
  s.field_world_uT = simulation.field_world_uT;
  read_triads(s, recording, simulation, muted);
  if (!s.present[0] && !s.present[1] && !s.present[2])
    return fail(ErrorKind::kBadData,
                "no sensor of the simulation has readings in the recording; check its column names");
  read_drivers(s, recording);
  s.rest = find_rest(s);
  if (s.present[kAcc] && 0.5 / s.dt_s > kVibration_Hz * 1.5) s.vibration = vibration_of(s);
  s.has_orientation = !recording.ref_q_world_body.empty();
  s.has_position = !recording.ref_position_m.empty();
  if (!s.has_orientation) return s;
  mute_lost_reference(s, recording);
  predict(s, recording);
  for (int k = 0; k < kSensors; ++k) {
    if (!s.present[k]) continue;
    s.residual[k] = s.reading[k] - s.predicted[k];
    mute_ends(s.muted[k], s.n, std::max<Eigen::Index>(2 * kStencilReach, static_cast<Eigen::Index>(kEnds_s / s.dt_s)));
    if (k != kAcc || s.has_position) continue;
    for (std::size_t i = 0; i < s.rest.size();
         ++i)  // without a position, only rest says what the accelerometer should read
      if (!s.rest[i]) s.muted[k][i] = 1;
  }
  choose_vectors(s);
  return s;
}

}  // namespace stillpoint::diag

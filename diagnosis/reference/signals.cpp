#include "diagnosis/reference/signals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/foreign/alignment.h"
#include "diagnosis/reference/band_limit.h"
#include "diagnosis/reference/folded_vibration.h"
#include "diagnosis/reference/prediction.h"
#include "diagnosis/reference/response.h"
#include "diagnosis/reference/rest.h"
#include "diagnosis/sanity/readings.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr double kMotionOverNoise =
    60.0;  // power; the noise in a driver then costs a candidate less than it costs to be named
constexpr double kVibration_Hz = 15.0;
constexpr double kStill_rad = 5e-3, kStill_m = 5e-3;  // rms; ten times what cameras err by
constexpr double kEnds_s = 0.6;  // where differences are one-sided and filters lean on the mirror image

void mute_ends(Mask& mask, Eigen::Index n, Eigen::Index ends) {
  for (Eigen::Index i = 0; i < std::min(ends, n); ++i) {
    mask[static_cast<std::size_t>(i)] = 1;
    mask[static_cast<std::size_t>(n - 1 - i)] = 1;
  }
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
    s.given[k] = s.triad[k] = triad;
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
  s.temperature_K = read(recording.temp_degC, sim::kReferenceTemp_degC);
  if (s.temperature_K.size()) s.temperature_K = moving_mean(s.temperature_K, static_cast<Eigen::Index>(0.5 / s.dt_s));
  s.current_A = read(recording.current_A, 0.0);
  s.voltage_V = read(recording.supply_V, 0.0);
  for (const auto& [name, column] : recording.user_columns)
    if (Series x = read(column, 0.0); x.size()) s.user[name] = std::move(x);
}

/// At rest nothing moves: there the vector is one value a rest, or the sensor's own noise would stand in residual and
/// driver alike. What bridges a gap of the reference counts for no attitude.
void hold_at_rest(Signals& s, const Mask& lost) {
  const auto rests = [&s](Eigen::Index i) { return s.rest[static_cast<std::size_t>(i)] != 0; };
  each_run(s.n, rests, [&](Eigen::Index begin, Eigen::Index end) {
    const Eigen::Index length = end - begin;
    Series seen(length);
    for (Eigen::Index i = 0; i < length; ++i) seen[i] = lost[static_cast<std::size_t>(begin + i)] ? 0.0 : 1.0;
    if (seen.sum() == 0.0) seen.setOnes();
    const auto hold = [&](Series3& x) {
      auto rows = x.middleRows(begin, length);
      rows.rowwise() = (seen.transpose() * rows / seen.sum()).eval();
    };
    for (Series3& v : s.vector) hold(v);
    for (Series3& v : s.world_axis) hold(v);
    s.vector[kGyr].middleRows(begin, length).setZero();
  });
}

bool keeps_still(const Series3& x, double still) {
  return (x.rowwise() - x.colwise().mean()).norm() < still * std::sqrt(static_cast<double>(x.rows()));
}

/// An axis of the world, or a place, that keeps still in a body that turns but for what a camera's own noise does to
/// it: the vertical of a turntable, the centre of it. As a driver it would be that noise, which the residual has, too.
void hold_what_keeps_still(Signals& s) {
  const auto hold = [](Series3& x, double still) {
    if (keeps_still(x, still)) x.rowwise() = x.colwise().mean().eval();
  };
  const auto still = [](const Series3& axis) { return keeps_still(axis, kStill_rad); };
  if (std::all_of(s.world_axis.begin(), s.world_axis.end(), still)) return;
  for (Series3& axis : s.world_axis) hold(axis, kStill_rad);
  if (s.has_position) hold(s.position_m, kStill_m);
}

/// Another simulator's field is what its log shows through the world's axes.
Vec3 field_shown(const Signals& s) {
  const Series3 field = in_world(s, s.predicted[kMag]);
  Vec3 sum = Vec3::Zero();
  double rows = 0.0;
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (!s.muted[kMag][static_cast<std::size_t>(i)]) sum += field.row(i).transpose(), rows += 1.0;
  return rows > 0.0 ? Vec3(sum / rows) : s.field_world_uT;
}

/// Which signal stands for the true vector: a noiseless reference; else the sensor itself, which is quieter than a
/// differentiated camera, in the band where things move.
void choose_vectors(Signals& s, const Mask& lost, bool turns_known) {
  const double highest = std::min(kMotionBand_Hz, 0.2 / s.dt_s);
  const auto band_of = [&](const Series3& x) {
    return motion_band_hz(x, s.rest, s.dt_s, kMotionOverNoise, 1.5, highest);
  };
  const auto limited_to = [&](double band_hz, const Series3& x) {
    return apply_response(x, s.rows, low_pass(band_hz));
  };
  const auto limited = [&](const Series3& x) { return limited_to(band_of(x), x); };
  if (!s.exact_reference) {
    for (Series3& axis : s.world_axis) {
      const double band_hz = band_of(axis);
      axis = limited_to(band_hz, axis);
      // The field is seen through these axes, and a filter carries what bridges a gap as far as this.
      mute_beside(lost, static_cast<Eigen::Index>(std::ceil(1.0 / (band_hz * s.dt_s))), s.muted[kMag]);
    }
    if (s.has_position) s.position_m = limited(s.position_m);
    hold_what_keeps_still(s);
  }
  for (int k = 0; k < kSensors; ++k) {
    const bool predicted = !vector_is_reading(s, static_cast<Sensor>(k));
    s.vector[k] = predicted ? s.predicted[k] : s.reading[k];
    if (s.exact_reference || (k == kMag && turns_known)) continue;
    const double band_hz = band_of(s.vector[k]);
    if (!predicted) s.band_hz[static_cast<std::size_t>(k)] = band_hz;
    s.vector[k] = limited_to(band_hz, s.vector[k]);
  }
  if (!s.exact_reference) hold_at_rest(s, lost);
  if (!s.exact_reference && turns_known) {
    // Of the same turns as the world's axes: where the two differ by their noise only, a field of the world that is
    // nothing but that noise would be fitted to it.
    const Vec3 field_uT = s.from_log && s.present[kMag] ? field_shown(s) : s.field_world_uT;
    s.vector[kMag] = in_body(s, field_uT.transpose().replicate(s.n, 1));
  }
  s.rate = s.vector[kGyr];
  s.rate_dot = derivative(s.rate, s.rows);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (!s.rest[static_cast<std::size_t>(i)]) continue;
    s.rate.row(i).setZero();
    s.rate_dot.row(i).setZero();
  }
}

/// What another simulator says that the sensors read takes the place of what the reference predicts.
void take_prediction(Signals& s, const AlignedLog& log) {
  constexpr double kSeenOverNoise = 0.05;  // of the log's own noise beside the recording's
  s.from_log = s.exact_reference = true;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    s.present[k] = s.present[k] && log.reading[k].rows() == s.n;
    if (!s.present[k]) continue;
    s.predicted[k] = log.reading[k];
    s.exact_reference = s.exact_reference && log.noise_sd[k] < kSeenOverNoise * s.noise_sd[k];
    for (std::size_t i = 0; i < log.unread[k].size(); ++i)
      if (log.unread[k][i]) s.muted[k][i] = 1;
  }
}

}  // namespace

bool vector_is_reading(const Signals& s, Sensor k) {
  return s.present[k] && k != kMag && !s.exact_reference && !s.from_log;
}

Series3 uncorrected(const sim::TriadConfig& triad, const Series3& vector) {
  return (vector * triad.matrix.inverse().transpose()).rowwise() + triad.bias.transpose();
}

Series3 in_world(const Signals& s, const Series3& body) {
  Series3 world(s.n, 3);
  for (int a = 0; a < 3; ++a)
    world.col(a) = body.cwiseProduct(s.world_axis[static_cast<std::size_t>(a)]).rowwise().sum();
  return world;
}

Series3 in_body(const Signals& s, const Series3& world) {
  Series3 body = Series3::Zero(s.n, 3);
  for (int a = 0; a < 3; ++a) body += world.col(a).asDiagonal() * s.world_axis[static_cast<std::size_t>(a)];
  return body;
}

Result<Signals> make_signals(const io::Recording& recording, const sim::SimulationConfig& simulation,
                             const std::array<Mask, kSensors>& muted, const AlignedLog* log,
                             Eigen::Index rows_a_frame) {
  Signals s;
  s.n = static_cast<Eigen::Index>(recording.size());
  s.dt_s = s.rows.step_s = even_step_s(recording);
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
  const Mask lost = predict(s, recording, rows_a_frame);
  if (log != nullptr)
    take_prediction(s, *log);
  else
    unfold_vibrations(s);
  for (int k = 0; k < kSensors; ++k) {
    if (!s.present[k]) continue;
    s.residual[k] = s.reading[k] - s.predicted[k];
    mute_ends(s.muted[k], s.n, std::max<Eigen::Index>(2 * kStencilReach, static_cast<Eigen::Index>(kEnds_s / s.dt_s)));
    if (k != kAcc || s.has_position || s.from_log) continue;
    for (std::size_t i = 0; i < s.rest.size();
         ++i)  // without a position, only rest says what the accelerometer should read
      if (!s.rest[i]) s.muted[k][i] = 1;
  }
  choose_vectors(s, lost, log == nullptr || !log->summed_up);
  return s;
}

}  // namespace stillpoint::diag

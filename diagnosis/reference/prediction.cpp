#include "diagnosis/reference/prediction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/FFT>

#include "core/so3.h"
#include "diagnosis/reference/decimals.h"
#include "diagnosis/reference/fast_length.h"
#include "diagnosis/reference/rest.h"

namespace stillpoint::diag {
namespace {

constexpr double kExactJitter_rad = 2e-6;  // a reference quieter than this is arithmetic, not a camera
constexpr double kSeenOverNoise = 0.05;    // an error of the reference that a sensor of this noise would show
constexpr double kKept = 0.6;  // of the rows, for which errors up to the next number times the noise are borne
constexpr double kBorneOverNoise = 0.3;
constexpr double kOften = 0.3;         // of the rows
constexpr double kUnresolved = 0.25;   // of the rate of the rows: a derivative of 17 of them errs beyond
constexpr double kShakes = 0.05;       // of the power of what moves
constexpr double kRotorsWidth = 0.02;  // of its frequency, on either side
constexpr double kFreeOfIt = 0.01;     // of the noise
constexpr double kAside_s = 0.3;       // from what is not
constexpr double kAboveStamps = 2.0;   // what the noise of stamps leaves between two stencils is less than itself

using Turns = Eigen::Matrix<double, Eigen::Dynamic, 4>;

/// One branch of the quaternions: q and -q are one rotation, differences need one of them. Missing where they are.
Turns turns_of(const io::Recording& recording) {
  Turns q(static_cast<Eigen::Index>(recording.size()), 4);
  Eigen::Vector4d last(1, 0, 0, 0);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Eigen::Vector4d& given = recording.ref_q_world_body[static_cast<std::size_t>(i)];
    if (!given.allFinite() || given.norm() < 0.5) {
      q.row(i).setConstant(io::kMissing);
      continue;
    }
    last = given.normalized() * (given.dot(last) < 0 ? -1.0 : 1.0);
    q.row(i) = last;
  }
  return q;
}

Series3 places_of(const io::Recording& recording) {
  Series3 p(static_cast<Eigen::Index>(recording.ref_position_m.size()), 3);
  for (Eigen::Index i = 0; i < p.rows(); ++i) p.row(i) = recording.ref_position_m[static_cast<std::size_t>(i)];
  return p;
}

template <class Columns>
Columns bridged(Columns x) {
  for (Eigen::Index c = 0; c < x.cols(); ++c) x.col(c) = filled(x.rows(), [&](Eigen::Index i) { return x(i, c); });
  return x;
}

/// omega = 2 q* dq/dt, exact for any rotation; differences of logarithms would miss the coning part.
Series3 rate_from(const Turns& q, const RowTimes& rows) {
  Series3 vector_part = q.rightCols<3>();
  Series3 scalar_part = Series3::Zero(q.rows(), 3);
  scalar_part.col(0) = q.col(0);
  const Series3 dv = derivative(vector_part, rows), dw = derivative(scalar_part, rows);
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
/// Between its frames a slower reference was interpolated, and shows none.
double jitter_without_rest(const Turns& rows, Eigen::Index rows_a_frame) {
  constexpr int kTimes = 8;
  constexpr double kGain = 113.4;  // of white noise: the root of the sum of the squared binomials of 8
  constexpr double kMedianOverSd = 0.6745;
  const Turns q = rows(Eigen::seq(0, Eigen::last, rows_a_frame), Eigen::all);
  Eigen::MatrixXd d = q.rightCols<3>();
  for (int k = 0; k < kTimes && d.rows() > 1; ++k) d = (d.bottomRows(d.rows() - 1) - d.topRows(d.rows() - 1)).eval();
  return 2.0 * quantile(d.cwiseAbs().rowwise().mean(), 0.5) / (kGain * kMedianOverSd);
}

/// Where the reference was lost, and beside it as far as its differences reach, nothing can be compared.
Mask mute_lost_reference(Signals& s, const io::Recording& recording) {
  constexpr Eigen::Index kReach = kStencilReach + 1;
  Mask lost(static_cast<std::size_t>(s.n), 0);
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const bool there =
        recording.ref_q_world_body[i].allFinite() && (!s.has_position || recording.ref_position_m[i].allFinite());
    if (!there) lost[i] = 1;
  }
  for (Mask& muted : s.muted) mute_beside(lost, kReach, muted);
  return lost;
}

/// What the reference's own roughness leaves in the derivatives of which the readings are predicted: of the stamps of
/// uneven rows, however many decimals they have. Even rows have no stamps to be wrong; theirs is `rounding_noise`.
std::array<double, 2> noise_of_stamps(const Signals& s, const Turns& turns, const Series3& places) {
  if (s.rows.even()) return {};
  return {s.has_position ? noise_of_second_derivative(roughness(places, s.rows), s.dt_s) : 0.0,
          2.0 * noise_of_derivative(roughness(turns, s.rows), s.dt_s)};
}

bool shows(const Signals& s, const std::array<double, 2>& noise) {
  const auto seen = [&](Sensor k) { return s.present[k] && noise[k] > kSeenOverNoise * s.noise_sd[k]; };
  return seen(kAcc) || seen(kGyr);
}

Mask near_above(const Series& near, double level) {
  Mask out(static_cast<std::size_t>(near.size()));
  for (Eigen::Index i = 0; i < near.size(); ++i) out[static_cast<std::size_t>(i)] = near[i] > level;
  return out;
}

/// As a rotor does: most of what the readings hold beyond the reach of a derivative is at one frequency. Steps and
/// strokes are fast for a moment, and spread over all.
bool vibrates(const Signals& s, Sensor k) {
  const Eigen::Index n = fast_length_within(s.n);
  Series power = Series::Zero(n / 2);
  Eigen::FFT<double> fft;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXcd spectrum;
    const Series x = s.reading[k].col(axis).head(n);
    fft.fwd(spectrum, x);
    power += spectrum.head(n / 2).cwiseAbs2();
  }
  const auto first = static_cast<Eigen::Index>(kUnresolved * static_cast<double>(n));
  Eigen::Index peak = 0;
  const double all = power.tail(power.size() - first).sum();
  power.tail(power.size() - first).maxCoeff(&peak);
  peak += first;
  const auto width = static_cast<Eigen::Index>(kRotorsWidth * static_cast<double>(peak));
  const Eigen::Index begin = std::max(first, peak - width), end = std::min(peak + width + 1, power.size());
  const double moves = power.tail(power.size() - 1).sum();  // without the mean
  return all > kShakes * moves && power.segment(begin, end - begin).sum() > 0.5 * all;
}

/// A vibration near half the rate of the reference cannot be differentiated: where what is left of the error stands
/// above the noise of the stamps and reaches the sensor's noise, nothing can be compared. A noisy camera carries its
/// noise there, and no error is seen.
void mute_unresolved(Signals& s, const std::array<Series, 2>& error, const std::array<double, 2>& of_stamps) {
  for (const Sensor k : {kAcc, kGyr}) {
    if (!s.present[k] || error[k].size() == 0) continue;
    const Series near = moving_mean(error[k].cwiseAbs2(), kStencilReach).cwiseSqrt();
    const double borne =
        std::clamp(quantile(near, kKept), kSeenOverNoise * s.noise_sd[k], kBorneOverNoise * s.noise_sd[k]);
    const double harmless = std::max(borne, kAboveStamps * of_stamps[k]);
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < s.n; ++i)
      if (std::uint8_t& muted = s.muted[k][static_cast<std::size_t>(i)]; near[i] > harmless && !muted)
        muted = 1, ++count;
    if (static_cast<double>(count) > kOften * static_cast<double>(s.n) && vibrates(s, k)) {
      // Where it swells and fades the two stencils may agree, on the frequency to which the rows fold it.
      const Mask fast = near_above(near, kFreeOfIt * s.noise_sd[k]);
      mute_beside(fast, static_cast<Eigen::Index>(kAside_s / s.dt_s), s.muted[k]);
      count = std::count(fast.begin(), fast.end(), 1);
    }
    const double share = static_cast<double>(count) / static_cast<double>(s.n);
    if (share < 0.005) continue;
    s.unresolved[k] = true;
    s.present[k] = share < 0.9;
    s.notices.push_back(fmt::format(
        "{}: in {:.0f} % of the rows the body vibrates too fast for a reference of {:.0f} rows a second; {}. Record "
        "the reference at four times the frequency of the vibration, or more",
        kSensorName[k], 100.0 * share, 1.0 / s.dt_s, s.present[k] ? "they are left out" : "the sensor is left out"));
  }
}

/// A reference of few decimals is a noisy one, although it is perfectly still at rest.
bool rounding_shows(const Signals& s, const io::Recording& recording) {
  const RoundingNoise noise = rounding_noise(recording, s.dt_s);
  return (s.present[kGyr] && noise.rate_radps > kSeenOverNoise * s.noise_sd[kGyr]) ||
         (s.present[kAcc] && noise.acceleration_mps2 > kSeenOverNoise * s.noise_sd[kAcc]);
}

/// Of the reference: rad/s in the body, m/s and m/s^2 in the world.
struct Motion {
  Series3 rate, velocity, acceleration;
};

Motion motion_of(Signals& s, const Turns& q, const Series3& p) {
  Motion m{rate_from(q, s.rows), {}, Series3::Zero(s.n, 3)};
  if (!s.has_position) return m;
  s.mean_position_m = p.colwise().mean();
  s.position_m = p.rowwise() - s.mean_position_m.transpose();
  m.velocity = derivative(p, s.rows);
  m.acceleration = second_derivative(p, s.rows);
  return m;
}

/// Nothing moves at rest: what a noisy reference shows there is its noise. An exact one shows the idling engine.
void hold_still_at_rest(const Mask& rest, Motion& m) {
  for (Eigen::Index i = 0; i < m.rate.rows(); ++i)
    if (rest[static_cast<std::size_t>(i)]) m.rate.row(i).setZero(), m.acceleration.row(i).setZero();
}

/// Root of the mean squared length of the rows.
template <class Derived>
double rms_of(const Eigen::MatrixBase<Derived>& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.rows()));
}

/// The poses of each rest without noise: the attitude at its mean, the place on a straight line, for to the sensors a
/// steady drive is a rest as well. Their derivatives beside the rests sum to nothing over the edges; those of noise
/// that is cut off at an edge do not. What is off by more than a camera's noise was no rest, and stays as it was seen.
void keep_edges_of_rests(Signals& s, Turns q, Series3 p, const Motion& m) {
  constexpr double kCameras_rad = 2e-3, kCameras_m = 1e-3;
  const auto rests = [&s](Eigen::Index i) { return s.rest[static_cast<std::size_t>(i)] != 0; };
  each_run(s.n, rests, [&](Eigen::Index begin, Eigen::Index end) {
    const Eigen::Index length = end - begin;
    auto turns = q.middleRows(begin, length);
    const Turns still = turns.colwise().mean().replicate(length, 1);
    if (2.0 * rms_of(turns - still) < kCameras_rad) turns = still;
    if (!s.has_position) return;
    auto places = p.middleRows(begin, length);
    const Series along = Series::LinSpaced(length, -1.0, 1.0);
    const Eigen::RowVector3d slope = along.transpose() * places / std::max(along.squaredNorm(), 1e-9);
    const Series3 line = (along * slope).rowwise() + places.colwise().mean();
    if (rms_of(places - line) < kCameras_m) places = line;
  });
  s.edges_of_rests[kGyr] = rate_from(q, s.rows) - m.rate;
  if (s.has_position) s.edges_of_rests[kAcc] = in_body(s, second_derivative(p, s.rows) - m.acceleration);
}

void predict_readings(Signals& s, const Turns& q, const Motion& m) {
  for (auto& axis : s.world_axis) axis.resize(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    const Mat3 R = Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)).normalized().toRotationMatrix();
    for (int a = 0; a < 3; ++a) s.world_axis[static_cast<std::size_t>(a)].row(i) = R.row(a);
  }
  Series3 felt = m.acceleration;
  felt.col(2).array() += s.gravity_mps2;
  s.predicted[kAcc] = in_body(s, felt);
  s.predicted[kGyr] = m.rate;
  s.predicted[kMag] = in_body(s, s.field_world_uT.transpose().replicate(s.n, 1));
}

}  // namespace

void mute_beside(const Mask& lost, Eigen::Index reach, Mask& muted) {
  const auto n = static_cast<Eigen::Index>(muted.size());
  Eigen::Index until = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!lost[static_cast<std::size_t>(i)]) continue;
    for (Eigen::Index k = std::max(until, i - reach); k <= std::min(i + reach, n - 1); ++k)
      muted[static_cast<std::size_t>(k)] = 1;
    until = i + reach + 1;
  }
}

Mask predict(Signals& s, const io::Recording& recording, Eigen::Index rows_a_frame) {
  Mask lost = mute_lost_reference(s, recording);
  const Turns given_q = turns_of(recording);
  const Series3 given_p = places_of(recording);
  Turns q = bridged(given_q);
  Series3 p = bridged(given_p);
  s.rows = times_of_rows(s.t_s, s.dt_s, given_q, given_p);
  Motion m = motion_of(s, q, p);
  const double own_jitter = s.rows.even() ? jitter_without_rest(q, rows_a_frame) : 2.0 * roughness(given_q, s.rows);
  const bool quiet_reference = own_jitter < kExactJitter_rad;
  wake_where_reference_moves(s.rest, m.rate, m.velocity, s.dt_s, quiet_reference);
  rest_where_reference_is_still(s.rest, s, m.rate, m.velocity, quiet_reference);
  wake_where_both_move(s.rest, s, m.rate);
  if (const double jitter = rest_jitter(s, m.rate); jitter >= 0.0 && !quiet_reference)
    wake_where_both_turn(s.rest, s, m.rate, jitter * s.dt_s);
  const double jitter = rest_jitter(s, m.rate);
  s.has_rest = jitter >= 0.0;
  s.reference_jitter_rad = s.has_rest ? jitter * s.dt_s : own_jitter;
  const bool arithmetic = s.reference_jitter_rad < kExactJitter_rad && !rounding_shows(s, recording);
  const std::array<double, 2> of_stamps = noise_of_stamps(s, given_q, given_p);
  s.exact_reference = arithmetic && !shows(s, of_stamps);
  if (arithmetic)
    mute_unresolved(s,
                    {s.has_position ? second_derivative_error(p, s.rows) : Series(),
                     2.0 * derivative_error(q.rightCols<3>(), s.rows)},
                    of_stamps);
  if (!s.exact_reference) hold_still_at_rest(s.rest, m);
  predict_readings(s, q, m);
  if (!s.exact_reference) keep_edges_of_rests(s, std::move(q), std::move(p), m);
  return lost;
}

}  // namespace stillpoint::diag

// How the reference turns against the sensors, slowly and by milliradians: markers settle on skin, a camera's
// calibration drifts. One turn must do to the accelerometer and the magnetometer what it does to gravity and the field,
// and its rate must be in the gyroscope: what two of them say of it independently is no physics of either.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/cross_rows.h"
#include "core/so3.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/regression.h"

namespace stillpoint::diag {
namespace {

constexpr double kShortestWander_s = 5.0;  // period; faster is the reference's noise, which the noise model has
constexpr double kExpected_rad = 3e-3;     // rms of an axis, for the prior of the course
constexpr double kMost_rad = 6e-3;         // more is a mount that moves: a law of time, to be told as one
constexpr double kOneAxis = 0.97;          // of the turning: a mount that gives way turns about one
constexpr double kSpeaks = 12.0;           // nats for one cause that two sensors see over one of each's own, or none
constexpr double kLate_s = 0.05, kVaries_s = 0.01;  // a lateness and its slow changes, for their prior
constexpr int kLateTerms = 5;
constexpr double kRows = 3000.0;  // a hundred and more in the shortest period

/// What may come from outside of the sensors, as columns with prior deviations of their coefficients: first turns,
/// cosines of the recording's length about three axes of the body or of the world; last a lateness that varies slowly,
/// which turns the reference by rate times time as well.
struct Basis {
  std::vector<Series3> turn, rate;
  Eigen::MatrixXd late;
  Eigen::VectorXd sd;
  double shortest_s = 0.0;  ///< period of the turns; kShortestWander_s in a recording that is not long
  [[nodiscard]] Eigen::Index turns() const { return static_cast<Eigen::Index>(turn.size()); }
};

/// A turn about an axis of the body or of the world, in the sensor's frame.
struct Turning {
  Series3 turn, rate;
};

Turning turning_about(const Signals& s, bool in_world, int axis, const Series& course_rad) {
  const Series3 about =
      in_world ? s.world_axis[static_cast<std::size_t>(axis)] : Series3(Vec3::Unit(axis).transpose().replicate(s.n, 1));
  Turning out{course_rad.asDiagonal() * about, derivative(course_rad.replicate(1, 3), s.rows).cwiseProduct(about)};
  if (in_world) out.rate -= cross_rows(s.rate, out.turn);  // the world's axes turn against the body
  for (Eigen::Index i = 0; i < s.n; ++i)                   // the reference's own rate is not believed at rest
    if (s.rest[static_cast<std::size_t>(i)]) out.rate.row(i).setZero();
  return out;
}

Basis make_basis(const Signals& s, bool in_world) {
  Basis out;
  const WalkBasis walk = walk_basis(s, kShortestWander_s);
  const Eigen::Index terms = walk->cols();
  for (int axis = 0; axis < 3; ++axis)
    for (Eigen::Index k = 0; k < terms; ++k) {
      Turning one = turning_about(s, in_world, axis, walk->col(k));
      out.turn.push_back(std::move(one.turn)), out.rate.push_back(std::move(one.rate));
    }
  out.late = Eigen::MatrixXd::Ones(s.n, kLateTerms);
  out.late.rightCols(kLateTerms - 1) = walk->leftCols(kLateTerms - 1);
  out.sd = Eigen::VectorXd::Constant(out.turns() + kLateTerms, kVaries_s);
  out.sd.head(out.turns()).setConstant(kExpected_rad * std::sqrt(2.0 / static_cast<double>(terms)));
  out.sd[out.turns()] = kLate_s;
  out.shortest_s = 2.0 * s.duration_s() / static_cast<double>(terms);
  return out;
}

/// What they do to a sensor's residual: v of the sensor is v - phi x v of the reference, and the rate has phi's; what
/// is late lacks its derivative.
Columns shown_in(const Signals& s, Sensor sensor, const Basis& basis) {
  const Series3& v = s.vector[sensor];
  Columns out;
  for (std::size_t j = 0; j < basis.turn.size(); ++j) {
    Series3 x = -cross_rows(basis.turn[j], v);
    if (sensor == kGyr) x += basis.rate[j];
    out.push_back({-1, x});
  }
  const Series3 late = -derivative(v, s.rows);
  for (Eigen::Index j = 0; j < basis.late.cols(); ++j) out.push_back({-1, basis.late.col(j).asDiagonal() * late});
  return out;
}

/// What one sensor says of the coefficients: log-likelihood score' c - c' information c / 2, its bias and matrix being
/// whatever they like.
struct Testimony {
  Sensor sensor = kAcc;
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
};

Testimony heard(const Target& t, const Columns& columns, const NoiseModel& noise) {
  const auto terms = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index n = t.layout.n, own = t.nuisance.cols();
  Testimony out{t.sensor, Eigen::MatrixXd::Zero(terms, terms), Eigen::VectorXd::Zero(terms)};
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd N(n, own), X(n, terms);
    for (Eigen::Index j = 0; j < own; ++j) N.col(j) = noise.whiten(t.layout, t.nuisance.col(j), axis);
    for (Eigen::Index j = 0; j < terms; ++j)
      X.col(j) = noise.whiten(t.layout, columns[static_cast<std::size_t>(j)].x.col(axis), axis);
    Eigen::MatrixXd beyond(n, terms + 1);
    beyond << X, noise.whiten(t.layout, t.residual.col(axis), axis);
    beyond -= N * N.colPivHouseholderQr().solve(beyond);
    out.information.noalias() += X.transpose() * beyond.leftCols(terms);
    out.score.noalias() += X.transpose() * beyond.col(terms);
  }
  return out;
}

/// Columns [begin, begin + count) of the basis.
struct Range {
  Eigen::Index begin = 0, count = 0;
};

/// What some sensors say together of some columns.
struct Together {
  std::vector<const Testimony*> sensors;
  Range columns;
  Eigen::VectorXd course;      ///< the likeliest
  double evidence_nats = 0.0;  ///< for one course that all of them see, over none
};

Together together(const Basis& basis, Range columns, std::vector<const Testimony*> sensors) {
  const Eigen::VectorXd sd = basis.sd.segment(columns.begin, columns.count);
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(columns.count, columns.count);  // in units of sd
  Eigen::VectorXd score = Eigen::VectorXd::Zero(columns.count);
  for (const Testimony* t : sensors) {
    information += sd.asDiagonal() * t->information.block(columns.begin, columns.begin, columns.count, columns.count) *
                   sd.asDiagonal();
    score += sd.cwiseProduct(t->score.segment(columns.begin, columns.count));
  }
  const Eigen::LLT<Eigen::MatrixXd> inverse(information);
  const Eigen::VectorXd course = inverse.solve(score);
  const double volume = inverse.matrixLLT().diagonal().array().log().sum();
  return {std::move(sensors), columns, sd.cwiseProduct(course), 0.5 * score.dot(course) - volume};
}

/// A turn, a lateness, both.
std::array<Range, 3> causes(const Basis& basis) {
  const Eigen::Index turns = basis.turns();
  return {Range{0, turns}, Range{turns, kLateTerms}, Range{0, turns + kLateTerms}};
}

/// A sensor that may speak, and what bias and matrix alone leave of it.
struct Witness {
  Target target;
  Series3 leftover;
};

std::vector<Witness> witnesses_of(const Signals& s) {
  constexpr double kLeastRows = 500.0;
  std::vector<Witness> out;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!s.present[k]) continue;
    Target target = make_target(s, k);
    if (target.layout.used() <= kLeastRows) continue;
    Series3 leftover = fit_profile(target, {}).leftover;
    out.push_back({std::move(target), std::move(leftover)});
  }
  return out;
}

/// Twice heard: the noise is what the first answer leaves over.
Testimony testimony_of(const Signals& s, const Witness& witness, const Basis& basis) {
  const auto& [target, leftover] = witness;
  const Columns columns = shown_in(s, target.sensor, basis);
  const Testimony first = heard(target, columns, NoiseModel(target.layout, leftover));
  const Series3 explained = contribution_of(columns, together(basis, causes(basis)[2], {&first}).course, s.n);
  return heard(target, columns, NoiseModel(target.layout, leftover - explained));
}

/// The cause outside that sensors see, where it is clearly likelier than that each is wrong in a way of its own or in
/// none. A sensor that does not share it must be wrong in its likeliest own way: a turn of the reference spares nobody.
std::optional<Together> agreed(const Basis& basis, const std::vector<Testimony>& all) {
  std::vector<double> alone;
  double apart = 0.0;
  for (const Testimony& t : all) {
    alone.push_back(-HUGE_VAL);
    for (const Range& cause : causes(basis))
      alone.back() = std::max(alone.back(), together(basis, cause, {&t}).evidence_nats);
    apart += std::max(0.0, alone.back());
  }
  std::optional<Together> best;
  double least = apart + kSpeaks;
  for (const Range& cause : causes(basis)) {
    // In a motion as slow as the turn one passes for a little of the other.
    const double price = cause.count > basis.turns() ? kSpeaks : 0.0;
    for (unsigned some = 1; some < 1u << all.size(); ++some) {
      std::vector<const Testimony*> sensors;
      double others = 0.0;
      for (std::size_t i = 0; i < all.size(); ++i)
        if (some >> i & 1u)
          sensors.push_back(&all[i]);
        else
          others += alone[i];
      if (sensors.size() < 2) continue;
      Together one = together(basis, cause, std::move(sensors));
      if (one.evidence_nats + others - price < least) continue;
      least = one.evidence_nats + others - price;
      best = std::move(one);
    }
  }
  return best;
}

/// Where no lateness is the cause, on every row. `duration_s`: of the rows that the course was found on.
Turning turning_of(const Signals& s, const Together& one, bool in_world, double duration_s) {
  Turning out{Series3::Zero(s.n, 3), Series3::Zero(s.n, 3)};
  if (one.columns.begin > 0) return out;
  const WalkBasis walk = walk_basis(s.t_s, duration_s, kShortestWander_s);
  const Eigen::Index terms = walk->cols();
  for (int axis = 0; axis < 3; ++axis) {
    const Turning part = turning_about(s, in_world, axis, *walk * one.course.segment(axis * terms, terms));
    out.turn += part.turn, out.rate += part.rate;
  }
  return out;
}

/// How much of the turning is about the axis that has most of it.
double share_of_one_axis(const Series3& turn) {
  const Series3 about = turn.rowwise() - turn.colwise().mean();
  const Mat3 spread = about.transpose() * about;
  return Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvalues()[2] / spread.trace();
}

}  // namespace

void take_out_wandering(Signals& s, Answer& answer) {
  if (s.exact_reference || s.from_log) return;
  const auto factor = std::max<Eigen::Index>(1, std::lround(static_cast<double>(s.n) / kRows));
  const Signals few = factor > 1 ? thinned(s, factor) : s;
  double evidence_nats = 0.0, shortest_s = 0.0;
  Turning turning;
  std::string who;
  const std::vector<Witness> witnesses = witnesses_of(few);
  for (const bool in_world : {false, true}) {
    const Basis basis = make_basis(few, in_world);
    std::vector<Testimony> all;
    all.reserve(witnesses.size());
    for (const Witness& w : witnesses) all.push_back(testimony_of(few, w, basis));
    const auto best = agreed(basis, all);
    if (!best || best->evidence_nats < evidence_nats) continue;
    evidence_nats = best->evidence_nats;
    turning = turning_of(s, *best, in_world, few.duration_s());
    shortest_s = basis.shortest_s;
    who.clear();
    for (const Testimony* t : best->sensors) who += (who.empty() ? "" : " and ") + std::string(kSensorName[t->sensor]);
  }
  const double rms_rad = turning.turn.norm() / std::sqrt(3.0 * static_cast<double>(s.n));
  if (rms_rad == 0.0 || rms_rad > kMost_rad || share_of_one_axis(turning.turn) > kOneAxis) return;
  s.reference_wanders = true;
  turn_into_sensor_frame(s, turning.turn);
  if (s.present[kGyr]) s.residual[kGyr] -= turning.rate, s.predicted[kGyr] += turning.rate;
  answer.diagnosis.notices.push_back(fmt::format(
      "reference: it turns slowly against the sensors, by {:.2g} rad rms about an axis, in periods of more than {:.0f} "
      "s: {} agree about it. What they agree about is taken out",
      rms_rad, shortest_s, who));
}

}  // namespace stillpoint::diag

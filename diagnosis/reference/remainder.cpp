#include "diagnosis/reference/remainder.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/reference/fitted_matrix.h"
#include "diagnosis/reference/lines.h"

namespace stillpoint::diag {
namespace {

constexpr double kConfigurationP = 1e-6;
constexpr double kOffOverVector = 2e-3;  // markers are set to milliradians
constexpr double kKnown =
    0.01;  // deviation of an entry of a matrix, or of a bias over the vector: the tenth of a data sheet's

/// The triad whose numbers are right.
sim::TriadConfig set_right(const Signals& s, Sensor k, const Fit& fit) {
  sim::TriadConfig out = s.triad[k];
  const Mat3 undo = undoing(s, k, fitted_matrix(fit));
  const Vec3 offset = fitted_offset(fit);
  out.bias += s.triad[k].matrix.inverse() * (vector_is_reading(s, k) ? Vec3(undo.inverse() * offset) : offset);
  out.matrix = undo * s.triad[k].matrix;
  return out;
}

/// What the readings, corrected as the simulation has it, are to the truth: (1 + D) true + offset.
struct Wrong {
  Vec3 offset;
  Mat3 D;
};

Wrong wrong_in(const sim::TriadConfig& given, const sim::TriadConfig& right) {
  return {given.matrix * (right.bias - given.bias), given.matrix * right.matrix.inverse() - Mat3::Identity()};
}

std::vector<Parameter> values_of(const sim::TriadConfig& right, const Eigen::MatrixXd& covariance, Sensor k) {
  std::vector<Parameter> out;
  const auto add = [&out](std::string name, double x, double variance, const char* unit) {
    const double half = 1.96 * std::sqrt(std::max(variance, 0.0));
    out.push_back({std::move(name), x, {x - half, x + half}, unit});
  };
  for (Eigen::Index i = 0; i < 3; ++i)
    add(fmt::format("bias_{}", "xyz"[i]), right.bias[i], covariance(4 * i, 4 * i), kSensorUnit[k]);
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      add(fmt::format("matrix_{}{}", "xyz"[i], "xyz"[j]), right.matrix(i, j), covariance(4 * i + 1 + j, 4 * i + 1 + j),
          "1");
  return out;
}

/// Numbers that this motion does not tell apart are not stated: a bias of some percent of the field and a matrix of
/// some percent can be the same thing.
bool well_conditioned(const Eigen::MatrixXd& covariance, double scale) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (std::sqrt(covariance(4 * axis, 4 * axis)) > kKnown * scale) return false;
    for (Eigen::Index j = 1; j < 4; ++j)
      if (std::sqrt(covariance(4 * axis + j, 4 * axis + j)) > kKnown) return false;
  }
  return true;
}

/// How far the readings are off in the mean over the recording, which is known even where its cause is not.
struct Reads {
  Vec3 off;
  double over_deviation = 0.0;  ///< chi-square of three
};

Reads reads(const Signals& s, Sensor k, const Layout& layout, const Fit& fit) {
  Eigen::Vector4d mean(1.0, 0.0, 0.0, 0.0);
  for (int axis = 0; axis < 3; ++axis)
    mean[axis + 1] = (s.vector[k].col(axis).array() * layout.counts).sum() / std::max(layout.used(), 1.0);
  const Vec3 off = fitted_offset(fit) + fitted_matrix(fit) * mean.tail<3>();
  Reads out;
  const Vec3 truth = vector_is_reading(s, k) ? Vec3(mean.tail<3>() - off) : Vec3(mean.tail<3>());
  out.off = s.given[k].matrix * s.triad[k].matrix.inverse() * (truth + off) - truth;
  for (int axis = 0; axis < 3; ++axis)
    out.over_deviation += out.off[axis] * out.off[axis] /
                          std::max(mean.dot(fit.nuisance_covariance.block<4, 4>(4 * axis, 4 * axis) * mean), 1e-300);
  return out;
}

std::string set_up_words(Sensor sensor, const std::string& id) {
  if (sensor == kMag) return "field_world_uT is wrong: another constant field fits";
  return id == kTurnedAttitudes ? "the world of the reference's attitudes is turned against that of its positions"
                                : "the vertical of the reference's world is not that of gravity";
}

void configuration_of(const Signals& s, const SensorSearch& search, const Finished& finished, Answer& answer) {
  Diagnosis& out = answer.diagnosis;
  const std::string sensor = kSensorName[search.sensor];
  for (const Found& f : search.found)
    if (f.id == kBodyVibration)
      out.notices.push_back(vibration_notice(search.sensor, f));
    else if (f.id == kSmoothedReference)
      out.notices.push_back(fmt::format(
          "reference: its attitudes are smoothed, or drawn as lines between slower frames; allowed for in {}", sensor));
    else if (f.kind == Kind::kConfiguration)
      out.configuration.push_back({sensor, set_up_words(search.sensor, f.id)});
  const bool thermal = std::any_of(search.found.begin(), search.found.end(), [](const Found& f) {
    return f.id.find("_temp_") != std::string::npos || f.id.find("_volt") != std::string::npos ||
           f.id.find("current") != std::string::npos;
  });
  const Eigen::MatrixXd& P = finished.fit.nuisance_covariance;
  const sim::TriadConfig right = set_right(s, search.sensor, finished.fit);
  const auto [offset, map] = wrong_in(s.given[search.sensor], right);
  double bias = 0.0, matrix = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 m = map.row(axis);
    bias += offset[axis] * offset[axis] / P(4 * axis, 4 * axis);
    matrix += m.dot(Mat3(P.block<3, 3>(4 * axis + 1, 4 * axis + 1)).ldlt().solve(m));
  }
  // Smaller than a thousandth is below what the true vector itself is known to.
  const double scale = std::sqrt(s.vector[search.sensor].rowwise().squaredNorm().mean());
  const bool bias_off = !thermal && chi_square_tail(bias, 3.0) < kConfigurationP && offset.norm() > 2e-4 * scale;
  const bool matrix_off = chi_square_tail(matrix, 9.0) < kConfigurationP && map.norm() > 1e-3;
  if (!well_conditioned(P, scale)) {
    const Reads r = reads(s, search.sensor, search.target.layout, finished.fit);
    if (thermal || chi_square_tail(r.over_deviation, 3.0) > kConfigurationP || r.off.norm() < kOffOverVector * scale)
      return;
    out.configuration.push_back({sensor, fmt::format("reads ({:.3g}, {:.3g}, {:.3g}) {} too much in the mean", r.off[0],
                                                     r.off[1], r.off[2], kSensorUnit[search.sensor])});
    out.notices.push_back(sensor +
                          ": this motion does not tell a wrong bias from a wrong matrix; turn it through more "
                          "attitudes");
    return;
  }
  if (bias_off)
    out.configuration.push_back({sensor, fmt::format("bias wrong by ({:.3g}, {:.3g}, {:.3g}) {}", offset[0], offset[1],
                                                     offset[2], kSensorUnit[search.sensor])});
  if (matrix_off)
    out.configuration.push_back(
        {sensor, fmt::format("matrix wrong by {:.2g} % (largest entry): reads (1 + D) times the truth, D in % = "
                             "[[{:.2f}, {:.2f}, {:.2f}], [{:.2f}, {:.2f}, {:.2f}], [{:.2f}, {:.2f}, {:.2f}]]",
                             100.0 * map.cwiseAbs().maxCoeff(), 100 * map(0, 0), 100 * map(0, 1), 100 * map(0, 2),
                             100 * map(1, 0), 100 * map(1, 1), 100 * map(1, 2), 100 * map(2, 0), 100 * map(2, 1),
                             100 * map(2, 2))});
  if ((!bias_off && !matrix_off) || thermal) return;
  answer.numbers[search.sensor] = right;
  out.configuration.back().values = values_of(*answer.numbers[search.sensor], P, search.sensor);
}

void residual_of(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out) {
  const Layout& layout = search.target.layout;
  const Sensor k = search.sensor;
  const Mat3 as_given = s.given[k].matrix * s.triad[k].matrix.inverse() - Mat3::Identity();
  const Series3 before = s.residual[k] + s.reading[k] * as_given.transpose();
  for (int axis = 0; axis < 3; ++axis) {
    ChannelResidual c;
    c.channel = fmt::format("{}_{}", kSensorName[k], kAxisName[static_cast<std::size_t>(axis)]);
    const auto rms = [&](const Series& x) {
      return std::sqrt((x.array().square() * layout.counts).sum() / std::max(layout.used(), 1.0));
    };
    c.rms_before = rms(before.col(axis));
    c.rms_after = rms(finished.fit.leftover.col(axis));
    c.white = is_white(finished.fit.whitened.col(axis), layout);
    const double sd = std::sqrt(std::max(finished.fit.nuisance_covariance(4 * axis, 4 * axis), 0.0));
    c.smallest_seen = std::sqrt(2.0 * (charge(1, {}) + kLeastNet)) * sd;
    c.unit = kSensorUnit[k];
    out.residual.push_back(c);
  }
}

}  // namespace

void report_remainder(const Signals& s, const SensorSearch& search, const Finished& finished, Answer& out) {
  configuration_of(s, search, finished, out);
  residual_of(s, search, finished, out.diagnosis);
}

}  // namespace stillpoint::diag

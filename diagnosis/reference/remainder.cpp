#include "diagnosis/reference/remainder.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr double kConfigurationP = 1e-6;

void configuration_of(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out) {
  const std::string sensor = kSensorName[search.sensor];
  for (const Found& f : search.found)
    if (f.kind == Kind::kConfiguration)
      out.configuration.push_back({sensor, "field_world_uT is wrong: another constant field fits"});
  const bool thermal = std::any_of(search.found.begin(), search.found.end(), [](const Found& f) {
    return f.id.find("_temp_") != std::string::npos || f.id.find("_volt") != std::string::npos ||
           f.id.find("current") != std::string::npos;
  });
  double bias = 0.0, matrix = 0.0;
  Vec3 offset;
  Mat3 map;
  const Eigen::VectorXd& x = finished.fit.nuisance;
  const Eigen::MatrixXd& P = finished.fit.nuisance_covariance;
  for (int axis = 0; axis < 3; ++axis) {
    offset[axis] = x[4 * axis];
    map.row(axis) = x.segment<3>(4 * axis + 1);
    const Eigen::Vector3d m = x.segment<3>(4 * axis + 1);
    bias += offset[axis] * offset[axis] / P(4 * axis, 4 * axis);
    matrix += m.dot(Mat3(P.block<3, 3>(4 * axis + 1, 4 * axis + 1)).ldlt().solve(m));
  }
  // Smaller than a thousandth is below what the true vector itself is known to.
  const double scale = std::sqrt(s.vector[search.sensor].rowwise().squaredNorm().mean());
  if (!thermal && chi_square_tail(bias, 3.0) < kConfigurationP && offset.norm() > 2e-4 * scale)
    out.configuration.push_back({sensor, fmt::format("bias wrong by ({:.3g}, {:.3g}, {:.3g}) {}", offset[0], offset[1],
                                                     offset[2], kSensorUnit[search.sensor])});
  if (chi_square_tail(matrix, 9.0) < kConfigurationP && map.norm() > 1e-3)
    out.configuration.push_back(
        {sensor, fmt::format("matrix wrong by {:.2g} % (largest entry): reads (1 + D) times the truth, D in % = "
                             "[[{:.2f}, {:.2f}, {:.2f}], [{:.2f}, {:.2f}, {:.2f}], [{:.2f}, {:.2f}, {:.2f}]]",
                             100.0 * map.cwiseAbs().maxCoeff(), 100 * map(0, 0), 100 * map(0, 1), 100 * map(0, 2),
                             100 * map(1, 0), 100 * map(1, 1), 100 * map(1, 2), 100 * map(2, 0), 100 * map(2, 1),
                             100 * map(2, 2))});
}

void residual_of(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out) {
  const Layout& layout = search.target.layout;
  for (int axis = 0; axis < 3; ++axis) {
    ChannelResidual c;
    c.channel = fmt::format("{}_{}", kSensorName[search.sensor], kAxisName[static_cast<std::size_t>(axis)]);
    const auto rms = [&](const Series& x) {
      return std::sqrt((x.array().square() * layout.counts).sum() / std::max(layout.used(), 1.0));
    };
    c.rms_before = rms(s.residual[search.sensor].col(axis));
    c.rms_after = rms(finished.fit.leftover.col(axis));
    c.white = is_white(finished.fit.whitened.col(axis), layout);
    const double sd = std::sqrt(std::max(finished.fit.nuisance_covariance(4 * axis, 4 * axis), 0.0));
    c.smallest_seen = std::sqrt(2.0 * (charge(1, {}) + kLeastNet)) * sd;
    c.unit = kSensorUnit[search.sensor];
    out.residual.push_back(c);
  }
}

}  // namespace

void report_remainder(const Signals& s, const SensorSearch& search, const Finished& finished, Diagnosis& out) {
  configuration_of(s, search, finished, out);
  residual_of(s, search, finished, out);
}

}  // namespace stillpoint::diag

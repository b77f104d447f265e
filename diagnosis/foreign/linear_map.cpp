#include "diagnosis/foreign/linear_map.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <vector>

#include "core/so3.h"
#include "core/units.h"

namespace stillpoint::diag {
namespace {

constexpr double kSameAxes_rad = 0.35;
constexpr double kUnseen = 1e-3;  // of the power of all axes: one that moves less says nothing of units or axes

/// What a factor between two logs of one quantity is known as; empty: none.
std::string unit_of_factor(Sensor k, double factor) {
  struct Known {
    Sensor sensor;
    double factor;
    const char* words;
  };
  static const std::vector<Known> all{{kGyr, kDegPerRad, "deg/s (name its columns gyr_x_dps, ...)"},
                                      {kAcc, 1.0 / kStandardGravity_mps2, "g (name its columns acc_x_g, ...)"},
                                      {kAcc, 101.97, "mg (divide by 1000 and name its columns acc_x_g, ...)"},
                                      {kMag, 0.01, "gauss (name its columns mag_x_gauss, ...)"},
                                      {kMag, 10.0, "milligauss (divide by 10)"},
                                      {kMag, 1e3, "nT (divide by 1000)"},
                                      {kMag, 1e-6, "tesla (name its columns mag_x_T, ...)"}};
  for (const Known& u : all)
    if (u.sensor == k && std::abs(std::log(factor / u.factor)) < 0.25) return u.words;
  return {};
}

/// "+y -x +z": the recording's axes in terms of the log's, where they are nearly a permutation.
std::string axes_of(const Mat3& R) {
  std::string out;
  for (int i = 0; i < 3; ++i) {
    Eigen::Index j = 0;
    if (R.row(i).cwiseAbs().maxCoeff(&j) < 0.8) return {};
    out += fmt::format("{}{}{}", i == 0 ? "" : " ", R(i, j) > 0 ? '+' : '-', "xyz"[j]);
  }
  return out;
}

}  // namespace

LinearMap linear_map(const Series3& x, const Series3& y, const Mask& outside) {
  const Eigen::Index n = x.rows();
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, 4), rhs = Eigen::MatrixXd::Zero(n, 3);
  for (Eigen::Index i = 0; i < n; ++i)
    if (!outside[static_cast<std::size_t>(i)]) design.row(i) << 1.0, x.row(i), rhs.row(i) = y.row(i);
  const Eigen::MatrixXd c = design.colPivHouseholderQr().solve(rhs);
  const auto rows = design.rightCols(3);
  const Eigen::RowVector3d sum = rows.colwise().sum();
  const Mat3 scatter = rows.transpose() * rows - sum.transpose() * sum / std::max(design.col(0).sum(), 1.0);
  return {Mat3(c.bottomRows(3).transpose()), (y - x * c.bottomRows(3)).rowwise() - c.row(0), scatter};
}

LinearMap map_of_the_better_half(const Series3& x, const Series3& y, const Mask& outside) {
  constexpr Eigen::Index kAround = 50;
  Series3 moves = y;
  for (Eigen::Index c = 0; c < 3; ++c) moves.col(c) -= moving_mean(y.col(c), kAround);
  const Series moved = moving_mean(moves.rowwise().squaredNorm(), kAround).array() + 1e-300;
  LinearMap map = linear_map(x, y, outside);
  for (int round = 0; round < 5; ++round) {
    const Series left = moving_mean(map.left.rowwise().squaredNorm(), kAround).array() / moved.array();
    const double middle = quantile(left, 0.5);
    Mask worse = outside;
    for (std::size_t i = 0; i < worse.size(); ++i) worse[i] = worse[i] || left[static_cast<Eigen::Index>(i)] > middle;
    map = linear_map(x, y, worse);
  }
  return map;
}

std::string difference(Sensor k, const LinearMap& map) {
  const Mat3& C = map.scatter;
  const double factor = std::sqrt((map.A * C * map.A.transpose()).trace() / std::max(C.trace(), 1e-300));
  const Mat3 unseen = Mat3::Identity() * (kUnseen * C.trace());
  const Mat3 A = (map.A * C + factor * unseen) * (C + unseen).inverse();
  if (factor < 0.67 || factor > 1.5) {
    const std::string unit = unit_of_factor(k, 1.0 / factor);
    return fmt::format("the {} of the simulated log is {:.4g} times that of the recording{}", kSensorName[k],
                       1.0 / factor,
                       unit.empty() ? "; give both in the units of docs/formats.md" : ": it looks like " + unit);
  }
  const Mat3 R = A * Eigen::SelfAdjointEigenSolver<Mat3>(A.transpose() * A).operatorInverseSqrt();  // of A = R S
  const std::string axes = axes_of(R);
  if (axes == "-x -y -z")
    return fmt::format(
        "{} negated{}; multiply by -1", kSensorWord[k],
        k == kAcc ? ": at rest the simulated log reads -g, the recording +g, or the other way round" : "");
  if (R.determinant() < 0.0)
    return fmt::format("the {} of the simulated log has other axes (mirrored{}): one of the two is left-handed",
                       kSensorName[k], axes.empty() ? "" : ": the recording's x, y, z are its " + axes);
  const double angle = log_so3(R).norm();
  if (angle < kSameAxes_rad) return {};
  return fmt::format(
      "the {} of the simulated log has other axes, turned by {:.0f} deg{}", kSensorName[k], angle * kDegPerRad,
      axes.empty() ? "; turn it into the sensor's frame"
                   : fmt::format(": the recording's x, y, z are its {0}; import it with mount: \"{0}\"", axes));
}

}  // namespace stillpoint::diag

/// Where the self-consistency model starts, and what its nuisances say of the simulation's numbers in the end.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

// Of a chi square of 3 and of 9 numbers: one in 1e8.
constexpr double kOffsetChiSquare = 40.0, kMatrixChiSquare = 58.0;
constexpr double kLeastMatrix = 1e-3;  // below, nobody would change a configuration

}  // namespace

/// What the gyro reads at rest beyond its calibration: an attitude integrated with it would be too far off to be put
/// right by small steps.
Vec3 SelfConsistency::offset_at_rest() const {
  const auto& gyro = *simulation_.gyroscope;
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (const auto& w : rest_)
    for (std::size_t i = w.first; i <= w.last; ++i)
      if (recording_.gyr_radps[i].allFinite()) sum += corrected(gyro, recording_.gyr_radps[i]), count += 1;
  return sum / std::max(count, 1.0);
}

/// Up from the first rest, heading from its field. Found once: it is the datum of the attitude knots.
Quat SelfConsistency::first_attitude() const {
  const auto& first = rest_.front();
  Vec3 up = Vec3::Zero(), field = Vec3::Zero();
  const auto& acc = *simulation_.accelerometer;
  for (std::size_t i = first.first; i <= first.last; ++i) {
    if (recording_.acc_mps2[i].allFinite()) up += corrected(acc, recording_.acc_mps2[i]);
    if (!mag_rows_.empty() && recording_.mag_uT[i].allFinite())
      field += corrected(*simulation_.magnetometer, recording_.mag_uT[i]);
  }
  up.normalize();
  Mat3 body, world;
  Vec3 across = up.cross(field), across_world = Vec3::UnitZ().cross(field_world_);
  if (across.norm() < 1e-6 || across_world.norm() < 1e-6) across = up.unitOrthogonal(), across_world = Vec3::UnitX();
  body << up, across.normalized(), up.cross(across.normalized());
  world << Vec3::UnitZ(), across_world.normalized(), Vec3::UnitZ().cross(across_world.normalized());
  return Quat(world * body.transpose());
}

std::vector<ConfigurationFault> SelfConsistency::wrong_numbers() const {
  std::vector<ConfigurationFault> out;
  const std::array<std::pair<Sensor, long>, 3> blocks{{{kGyr, kGyroAt}, {kAcc, kAccAt}, {kMag, kMagAt}}};
  // A common turn of all sensors against the body changes nothing that they see: it is the accelerometer's here.
  const Mat3 acc = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(x_.data() + kAccAt);
  const Mat3 turn = 0.5 * (acc - acc.transpose());
  for (const auto& [sensor, at] : blocks) {
    if (sensor == kMag && mag_rows_.empty()) continue;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(gram_->rows(), 12);
    for (long i = 0; i < 12; ++i) unit(at + i, i) = 1.0;
    const Eigen::MatrixXd P = gram_->solve(unit).middleRows(at, 12) * std::max(1.0, dispersion());
    Eigen::VectorXd matrix = x_.segment(at, 9);
    for (int i = 0; i < 9; ++i) matrix[i] -= turn(i / 3, i % 3);
    const Vec3 offset = x_.segment<3>(at + 9);
    if (offset.dot(Mat3(P.bottomRightCorner<3, 3>()).ldlt().solve(offset)) > kOffsetChiSquare)
      out.push_back({kSensorName[sensor], fmt::format("bias wrong by ({:.3g}, {:.3g}, {:.3g}) {}", offset[0], offset[1],
                                                      offset[2], kSensorUnit[sensor])});
    const double largest = matrix.cwiseAbs().maxCoeff();
    if (largest > kLeastMatrix && matrix.dot(P.topLeftCorner<9, 9>().ldlt().solve(matrix)) > kMatrixChiSquare)
      out.push_back({kSensorName[sensor],
                     fmt::format("matrix wrong by {:.2g} % (largest entry), as rests and turns among themselves show: "
                                 "reads (1 + D) times the truth, D in % = [{:.2f}]",
                                 100.0 * largest, fmt::join(Eigen::VectorXd(100.0 * matrix), ", "))});
  }
  return out;
}

}  // namespace stillpoint::diag::detail

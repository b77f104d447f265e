/// Where the self-consistency model starts, and what its nuisances say of the simulation's numbers in the end.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

// Of a chi square of 3 and of 9 numbers: one in 1e8.
constexpr double kOffsetChiSquare = 40.0, kMatrixChiSquare = 58.0;
constexpr double kFirst_s = 1.0;  // of a recording without a rest
// Below, nobody would change a configuration; of the vector itself, what it is known to.
constexpr double kLeastMatrix = 1e-3, kLeastOffset = 2e-4;
constexpr double kBeyondBelief = 4.0;  // of what is expected of a matrix: 20 %
constexpr double kKnown = 0.1;         // of what was known before: what the recording, not the expectation, tells

/// Departures of the simulation's numbers, as far as the recording knows them.
struct Known {
  Eigen::VectorXd value;
  double chi_square = 0.0;
  double most = 0.0;  ///< of what was expected
};

/// Their part along the directions that the recording knows far better than was expected. The others are bent by
/// whatever the model has not, up to many times what was expected of them.
Known known(const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& expected) {
  const Eigen::MatrixXd scaled =
      expected.cwiseInverse().asDiagonal() * covariance * expected.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> directions(scaled);
  Known out{Eigen::VectorXd::Zero(value.size())};
  for (long i = 0; i < value.size(); ++i) {
    const double variance = directions.eigenvalues()[i];
    if (!(variance < kKnown * kKnown)) continue;
    const Eigen::VectorXd direction = directions.eigenvectors().col(i);
    const double along = direction.dot(value.cwiseQuotient(expected));
    out.value += along * expected.cwiseProduct(direction);
    out.chi_square += along * along / std::max(variance, 1e-300);
    out.most = std::max(out.most, std::abs(along));
  }
  return out;
}

/// One that the recording tells, with its interval.
void add_value(std::string name, double value, double sd, double expected, const char* unit,
               ConfigurationFault& fault) {
  if (sd < kKnown * expected)
    fault.values.push_back({std::move(name), value, {value - 1.96 * sd, value + 1.96 * sd}, unit});
}

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

/// Up from the first rest, heading from its field; without a rest from the first second. Found once: it is the datum of
/// the attitude knots.
Quat SelfConsistency::first_attitude() const {
  RestWindow first;
  if (!rest_.empty())
    first = rest_.front();
  else
    while (first.last + 1 < recording_.size() && recording_.t_s(first.last) < recording_.t_s(0) + kFirst_s)
      ++first.last;
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

std::optional<std::vector<ConfigurationFault>> SelfConsistency::wrong_numbers() const {
  std::vector<ConfigurationFault> out;
  const std::array<std::pair<Sensor, long>, 3> blocks{{{kGyr, kGyroAt}, {kAcc, kAccAt}, {kMag, kMagAt}}};
  const Estimate all = numbers_beside_wander(kFieldAt);
  const auto known_at = [&](long at, long count) {
    return known(all.value.segment(at, count), all.covariance.block(at, at, count, count),
                 prior_sd_.segment(at, count));
  };
  // A common turn of all sensors against the body changes nothing that they see: it is the accelerometer's here.
  const Eigen::VectorXd of_acc = known_at(kAccAt, 9).value;
  const Mat3 acc = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(of_acc.data());
  const Mat3 turn = 0.5 * (acc - acc.transpose());
  double rate2 = 0.0;
  for (const Vec3& w : rate_) rate2 += w.squaredNorm() / static_cast<double>(rate_.size());
  const std::array<double, 3> size{simulation_.gravity_mps2, std::sqrt(rate2), field_world_.norm()};  // by Sensor
  for (const auto& [sensor, at] : blocks) {
    if (sensor == kMag && mag_rows_.empty()) continue;
    const Known offset = known_at(at + 9, 3);
    Known matrix = known_at(at, 9);
    if (matrix.most > kBeyondBelief) return std::nullopt;
    for (int i = 0; i < 9 && matrix.chi_square > 0.0; ++i) matrix.value[i] -= turn(i / 3, i % 3);
    const sim::TriadConfig& given = *triad(simulation_, sensor);
    const Mat3 right = (Mat3::Identity() - Eigen::Map<const RowMajor3>(matrix.value.data())) * given.matrix;
    const Eigen::VectorXd sd = all.covariance.diagonal().segment(at, 12).cwiseSqrt();
    if (offset.value.norm() > kLeastOffset * size[sensor] && offset.chi_square > kOffsetChiSquare) {
      out.push_back({kSensorName[sensor], fmt::format("bias wrong by ({:.3g}, {:.3g}, {:.3g}) {}", offset.value[0],
                                                      offset.value[1], offset.value[2], kSensorUnit[sensor])});
      const Mat3 as_settled = Mat3::Identity() - Eigen::Map<const RowMajor3>(all.value.data() + at);
      const Vec3 bias =
          given.bias + (as_settled * given.matrix).inverse() * offset.value;  // whichever way it is turned
      for (int i = 0; i < 3; ++i)
        add_value(fmt::format("bias_{}", "xyz"[i]), bias[i], sd[9 + i], prior_sd_[at + 9 + i], kSensorUnit[sensor],
                  out.back());
    }
    const double largest = matrix.value.cwiseAbs().maxCoeff();
    if (largest > kLeastMatrix && matrix.chi_square > kMatrixChiSquare) {
      out.push_back({kSensorName[sensor],
                     fmt::format("matrix wrong by {:.2g} % (largest entry), as rests and turns among themselves show: "
                                 "reads (1 + D) times the truth, D in % = [{:.2f}]",
                                 100.0 * largest, fmt::join(Eigen::VectorXd(100.0 * matrix.value), ", "))});
      for (int i = 0; i < 9; ++i)
        add_value(fmt::format("matrix_{}{}", "xyz"[i / 3], "xyz"[i % 3]), right(i / 3, i % 3), sd[i], prior_sd_[at + i],
                  "1", out.back());
    }
  }
  return out;
}

}  // namespace stillpoint::diag::detail

/// Where nothing rests the self-consistency model starts from the motion itself.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/so3.h"
#include "diagnosis/no_reference/closure.h"
#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kApart_s = 0.5;  // two moments: far enough for an offset to show, near enough for it to be linear

using Offsets = Eigen::Vector<double, 6>;  ///< of gyroscope and magnetometer

}  // namespace

/// Offsets that make the field of one moment, turned by the rate, that of half a second later:
/// m_b - A m_a = (I - A) h - [A m_a]x J d, where A turns body a to body b and J d is what the offset d turns meanwhile.
void SelfConsistency::start_in_motion() {
  const auto& r = recording_;
  const auto field = [&](std::size_t row) { return corrected(*simulation_.magnetometer, r.mag_uT[row]); };
  std::vector<Vec3> rate(r.size(), Vec3::Zero());
  for (std::size_t i = 0; i < r.size(); ++i)
    if (r.gyr_radps[i].allFinite()) rate[i] = corrected(*simulation_.gyroscope, r.gyr_radps[i]);
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Offsets sum = Offsets::Zero();
  for (std::size_t k = 0; k < mag_rows_.size();) {
    const std::size_t a = mag_rows_[k];
    while (k < mag_rows_.size() && r.t_s(mag_rows_[k]) < r.t_s(a) + kApart_s) ++k;
    if (k == mag_rows_.size()) break;
    const std::size_t b = mag_rows_[k];
    Mat3 A = Mat3::Identity(), J = Mat3::Zero();
    for (std::size_t i = a + 1; i <= b; ++i) {
      const Mat3 turn = turn_between(r, rate, i - 1, i).toRotationMatrix().transpose();
      A = turn * A;
      J = turn * J + (r.t_s(i) - r.t_s(i - 1)) * Mat3::Identity();
    }
    Eigen::Matrix<double, 3, 6> by;
    by << -skew(A * field(a)) * J, Mat3::Identity() - A;
    information += by.transpose() * by;
    sum += by.transpose() * (field(b) - A * field(a));
  }
  Offsets expected;
  expected << prior_sd_.segment<3>(kGyroAt + 9), prior_sd_.segment<3>(kMagAt + 9);
  const double variance = 2.0 * std::pow(simulation_.magnetometer->noise_sd, 2);
  information.diagonal() += (variance + 1e-12) * expected.cwiseAbs2().cwiseInverse();
  const Offsets found = information.ldlt().solve(sum);
  x_.segment<3>(kGyroAt + 9) = found.head<3>();
  x_.segment<3>(kMagAt + 9) = found.tail<3>();
}

}  // namespace stillpoint::diag::detail

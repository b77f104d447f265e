#include "bench/portfolio_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/units.h"

namespace stillpoint::bench {
namespace {

constexpr double kThreeSigma2 = 9.0;         ///< of one degree of freedom
constexpr double kThreeSigmaPlane2 = 11.83;  ///< the same probability, 99.73 %, of two

}  // namespace

double Tally::rms_deg(double sum, std::size_t n) {
  return n > 0 ? std::sqrt(sum / static_cast<double>(n)) * kDegPerRad : 0.0;
}

double Tally::worst_deg() const { return worst_rad_ * kDegPerRad; }

Judged judge(const Quat& truth, const pipeline::Processed& p) {
  Judged j;
  const auto& e = p.attitude;
  const Quat estimate(e.q_world_body[0], e.q_world_body[1], e.q_world_body[2], e.q_world_body[3]);
  Quat error = truth * estimate.conjugate();
  if (error.w() < 0.0) error.coeffs() *= -1.0;
  j.total_rad = 2.0 * std::acos(std::min(1.0, std::abs(error.w())));
  const double heading = 2.0 * std::atan2(error.z(), error.w());
  j.heading_rad = std::abs(std::remainder(heading, 2.0 * std::numbers::pi));
  // What is left when the turn about the vertical is taken out: a turn about a horizontal axis.
  const Vec3 tilt = log_quat(error * Quat(Eigen::AngleAxisd(-heading, Vec3::UnitZ())));
  j.tilt_rad = tilt.norm();
  const Mat3 covariance = mat(e.covariance_world_rad2);
  const Eigen::Matrix2d plane = covariance.topLeftCorner<2, 2>();
  j.tilt2 = tilt.head<2>().dot(plane.inverse() * tilt.head<2>());
  j.heading2 = j.heading_rad * j.heading_rad / covariance(2, 2);
  j.tilt_inside = j.tilt2 <= kThreeSigmaPlane2;
  j.heading_inside = j.heading2 <= kThreeSigma2;
  j.ok = pipeline::to_message(p).status == AttitudeStatus::kOk;
  return j;
}

void Tally::add(const Truth& truth, const pipeline::Processed& p) {
  const Judged j = judge(truth.q_world_body, p);
  tilt_inside_ += j.tilt_inside ? 1.0 : 0.0;
  heading_inside_ += j.heading_inside ? 1.0 : 0.0;
  // An estimate with no variance at all would make one sample outweigh a recording.
  tilt_nees_ += std::isfinite(j.tilt2) ? std::min(0.5 * j.tilt2, 1e3) : 1e3;
  heading_nees_ += std::isfinite(j.heading2) ? std::min(j.heading2, 1e3) : 1e3;
  ok_outside_ += j.ok && !(j.tilt_inside && j.heading_inside) ? 1.0 : 0.0;
  ++judged_;
  if (!truth.scored) return;
  total2_ += j.total_rad * j.total_rad;
  heading2_ += j.heading_rad * j.heading_rad;
  inclination2_ += j.tilt_rad * j.tilt_rad;
  worst_rad_ = std::max(worst_rad_, j.total_rad);
  ++scored_;
}

}  // namespace stillpoint::bench

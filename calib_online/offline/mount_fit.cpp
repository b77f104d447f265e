#include "calib_online/offline/mount_fit.h"

#include <Eigen/Dense>
#include <cmath>

#include "calib_online/offline/axis_maps.h"

namespace stillpoint::calib {

std::string_view name(MountLack lack) noexcept {
  switch (lack) {
    case MountLack::kNone:
      return "none";
    case MountLack::kNoSensor:
      return "no sensor";
    case MountLack::kNoRest:
      return "no rest";
    case MountLack::kOnePose:
      return "one pose";
    case MountLack::kNoTurn:
      return "no turn";
    case MountLack::kOneAxis:
      return "one axis";
    case MountLack::kAmbiguous:
      return "ambiguous";
    case MountLack::kContradiction:
      return "contradiction";
    case MountLack::kNoGyroscope:
      return "no gyroscope";
    case MountLack::kFieldLevel:
      return "field level";
    case MountLack::kMirrored:
      return "mirrored";
  }
  return "?";
}

MountFit fit_mount(const MountEvidence& evidence, const MountParams& params) {
  MountFit fit;
  fit.acc = fit_acc_mount(evidence, params);
  fit.gyr = fit_gyr_mount(evidence, fit.acc, params);
  fit.mag = fit_mag_mount(evidence, fit.acc, fit.gyr, params);
  return fit;
}

NamedMount named(const Mat3& R, const Mat3& covariance) {
  constexpr double kChiSquare3_99 = 11.345;
  NamedMount out;
  out.map = nearest_axis_map(R);
  out.rest_rad = log_so3(R * out.map.transpose());
  out.rest_sd_rad = covariance.diagonal().cwiseSqrt();
  const double angle_rad = out.rest_rad.norm();
  const Vec3 axis = angle_rad > 0.0 ? Vec3(out.rest_rad / angle_rad) : Vec3(Vec3::UnitX());
  out.angle_sd_rad = std::sqrt(axis.dot(covariance * axis));
  out.significant = out.rest_rad.dot(covariance.ldlt().solve(out.rest_rad)) > kChiSquare3_99;
  return out;
}

}  // namespace stillpoint::calib

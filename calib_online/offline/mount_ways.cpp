#include "calib_online/offline/mount_ways.h"

#include <algorithm>

#include "core/so3.h"

namespace stillpoint::calib {

Mat3 symmetric(const Vec6& s) {
  Mat3 S;
  S << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return S;
}

Mat36 symmetric_times(const Vec3& v) {
  Mat36 B;
  B << v.x(), 0, 0, v.y(), v.z(), 0, 0, v.y(), 0, v.x(), 0, v.z(), 0, 0, v.z(), 0, v.x(), v.y();
  return B;
}

AccWay in_acc_axes(const Preintegrated& way, const Mat3& R_acc_gyr, const Vec6& gyr_shape) {
  AccWay out;
  Mat36 by_shape;  // of the rotation vector at the end, gyroscope's axes
  for (int k = 0; k < 6; ++k) {
    const Mat3 unit = symmetric(Vec6::Unit(k));
    Vec3 column = Vec3::Zero();
    for (int row = 0; row < 3; ++row) column += way.J.middleCols<3>(3 * row) * unit.row(row).transpose();
    by_shape.col(k) = column;
  }
  const Mat3 E = way.q.toRotationMatrix() * exp_so3(by_shape * gyr_shape);
  out.R = R_acc_gyr * E * R_acc_gyr.transpose();
  out.d_end_d_shape = R_acc_gyr * by_shape;
  return out;
}

bool MapSearch::unique() const {
  return best && (!rival || rival->chi2 - best->chi2 > kRivalChi2 * std::max(1.0, best->excess()));
}

MapSearch search_maps(const VecX& x_sd, const Residuals& residuals) {
  constexpr double kAnother_rad = 20.0 * kRadPerDeg;
  std::vector<RotationFit> fits;
  for (const Mat3& map : axis_maps()) fits.push_back(fit_rotation(map, x_sd, residuals));
  std::sort(fits.begin(), fits.end(), [](const auto& a, const auto& b) { return a.chi2 < b.chi2; });
  MapSearch out{fits.front(), std::nullopt};
  for (const RotationFit& fit : fits)
    if (!out.rival && log_so3(fit.R * out.best->R.transpose()).norm() > kAnother_rad) out.rival = fit;
  return out;
}

}  // namespace stillpoint::calib

/// What gyroscope and magnetometer share: a way between two rests in the accelerometer's axes, and how it depends on
/// what is not known of the gyroscope.
#pragma once
#include <optional>

#include "calib_online/offline/axis_maps.h"
#include "calib_online/offline/mount_fit.h"
#include "calib_online/offline/rotation_fit.h"

namespace stillpoint::calib {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat36 = Eigen::Matrix<double, 3, 6>;

/// A symmetric matrix of six numbers: scales, then shears xy, xz, yz.
[[nodiscard]] Mat3 symmetric(const Vec6& s);
/// d(symmetric(s) v) / ds
[[nodiscard]] Mat36 symmetric_times(const Vec3& v);

/// v_start = R v_end, R = G E exp(J s) G^T.
struct AccWay {
  Mat3 R = Mat3::Identity();
  Mat36 d_end_d_shape = Mat36::Zero();  ///< rotation vector at the end by the gyroscope's six
};
[[nodiscard]] AccWay in_acc_axes(const Preintegrated& way, const Mat3& R_acc_gyr, const Vec6& gyr_shape);

/// Fits of one kind from all 24 maps.
struct MapSearch {
  std::optional<RotationFit> best;
  std::optional<RotationFit> rival;  ///< the best of those that are another rotation
  /// Nothing else fits nearly as well.
  [[nodiscard]] bool unique() const;
};
[[nodiscard]] MapSearch search_maps(const VecX& x_sd, const Residuals& residuals);

inline constexpr double kRivalChi2 = 9.0;         ///< a rival worse by less than this, three sd, is not excluded
inline constexpr double kContradictExcess = 9.0;  ///< three times as far off as stated: something else is wrong

}  // namespace stillpoint::calib

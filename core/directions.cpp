#include "core/directions.h"

#include <Eigen/SVD>
#include <algorithm>

namespace stillpoint {

Quat turn_between(const Vec3& from, const Vec3& to) {
  constexpr double kOpposite = 1e-12;
  const Vec3 a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  if (cosine < kOpposite - 1.0) return Quat(Eigen::AngleAxisd(std::acos(std::max(cosine, -1.0)), a.unitOrthogonal()));
  const double s = std::sqrt(2.0 * (1.0 + cosine));
  Quat q;
  q.vec() = a.cross(b) * (1.0 / s);
  q.w() = 0.5 * s;
  return q;
}

Mat3 nearest_orthogonal(const Mat3& M, double determinant) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 signs = Mat3::Identity();
  signs(2, 2) = std::copysign(1.0, determinant * (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs * svd.matrixV().transpose();
}

Vec3 singular_values(const Mat3& M) { return Eigen::JacobiSVD<Mat3>(M).singularValues(); }

double distortion(const Mat3& M) {
  const Vec3 stretch = singular_values(M);
  return std::max(stretch[0], 1.0 / stretch[2]);
}

}  // namespace stillpoint

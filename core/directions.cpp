#include "core/directions.h"

#include <Eigen/SVD>
#include <algorithm>

namespace stillpoint {

Mat3 nearest_orthogonal(const Mat3& M, double determinant) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 signs = Mat3::Identity();
  signs(2, 2) = std::copysign(1.0, determinant * (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs * svd.matrixV().transpose();
}

double distortion(const Mat3& M) {
  const Vec3 stretch = M.jacobiSvd().singularValues();
  return std::max(stretch[0], 1.0 / stretch[2]);
}

}  // namespace stillpoint

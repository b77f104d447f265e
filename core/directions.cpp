#include "core/directions.h"

#include <Eigen/SVD>

namespace stillpoint {

Mat3 nearest_orthogonal(const Mat3& M, double determinant) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 signs = Mat3::Identity();
  signs(2, 2) = std::copysign(1.0, determinant * (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs * svd.matrixV().transpose();
}

}  // namespace stillpoint

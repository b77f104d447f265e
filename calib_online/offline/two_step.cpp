#include "calib_online/offline/two_step.h"

#include <Eigen/Dense>

namespace stillpoint::calib {
namespace {

constexpr double kUnobserved = 1e-10;
constexpr double kNoGap = 1e-6;  // of the leading eigenvalues: two reference vectors fit equally well

bool invertible(const Mat3& gram) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(gram, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > kUnobserved * eigen.eigenvalues()[2];
}

/// H(u) = [S_1 u, S_2 u, S_3 u] G^-1, the minimum over H for a fixed u: (Z 30) from sums.
Mat3 matrix_for(const TwoStepSums& s, const Mat3& gram_inv, const Vec3& u) {
  Mat3 M;
  M << s.S[0] * u, s.S[1] * u, s.S[2] * u;
  return M * gram_inv;
}

}  // namespace

TwoStepFit two_step_closed(const TwoStepSums& s, double magnitude, const Mat3& H_prior) noexcept {
  TwoStepFit fit;
  if (s.count < 4.0 || !invertible(s.gram)) return fit;
  const Mat3 gram_inv = s.gram.inverse();
  Mat3 T = Mat3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t m = 0; m < 3; ++m)
      T += gram_inv(static_cast<int>(k), static_cast<int>(m)) * s.S[k].transpose() * s.S[m];
  T = (0.5 / s.count * (T + T.transpose())).eval();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(T);
  fit.contraction = eigen.eigenvalues()[1] / eigen.eigenvalues()[2];
  if (!(1.0 - fit.contraction > kNoGap)) return fit;
  fit.u = magnitude * eigen.eigenvectors().col(2);
  fit.H = matrix_for(s, gram_inv, fit.u);
  if ((fit.H.cwiseProduct(H_prior)).sum() < 0.0) {
    fit.H = -fit.H;
    fit.u = -fit.u;
  }
  fit.status = FitStatus::kOk;
  return fit;
}

TwoStepFit two_step_iterated(std::span<const Vec3> y, std::span<const Mat3> R, const Vec3& u0, double magnitude,
                             int iterations) {
  TwoStepFit fit;
  Mat3 gram = Mat3::Zero();
  for (const Vec3& v : y) gram += v * v.transpose();
  if (y.size() < 4 || !invertible(gram)) return fit;
  const Mat3 gram_inv = gram.inverse();
  Vec3 u = u0;
  for (int k = 0; k < iterations; ++k) {
    Mat3 numerator = Mat3::Zero();
    for (std::size_t j = 0; j < y.size(); ++j) numerator += (R[j] * u) * y[j].transpose();
    fit.H = numerator * gram_inv;  // C2M(R u) Y^+, (Z 30)
    u.setZero();
    // The stacked rotations have orthonormal columns but for the factor J: R^+ = R^T / J, (Z 31).
    for (std::size_t j = 0; j < y.size(); ++j) u += R[j].transpose() * fit.H * y[j] / static_cast<double>(y.size());
  }
  const double rescale = magnitude / u.norm();  // (Z 32)
  fit.H *= rescale;
  fit.u = rescale * u;
  fit.status = FitStatus::kOk;
  return fit;
}

}  // namespace stillpoint::calib

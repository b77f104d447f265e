#include "core/so3.h"

#include <gtest/gtest.h>

namespace stillpoint {
namespace {

TEST(So3, LogarithmUndoesTheExponentialAtEverySize) {
  for (const double size : {0.0, 1e-9, 1e-5, 1e-3, 0.5, 3.1}) {
    const Vec3 phi = size * Vec3(1, -2, 0.5).normalized();
    EXPECT_LT((log_quat(exp_quat(phi)) - phi).norm(), 1e-12) << size;
    EXPECT_LT((log_quat(Quat(-exp_quat(phi).coeffs())) - phi).norm(), 1e-12) << "q and -q are one rotation, " << size;
  }
}

TEST(So3, SeriesMeetTheClosedFormsWhereTheyTakeOver) {
  const Vec3 axis = Vec3(0.6, -1, 0.3).normalized();
  for (const double size : {0.0499, 0.0501, 0.0999, 0.1001, 0.1999, 0.2001}) {
    const Vec3 phi = size * axis;
    const Quat closed(Eigen::AngleAxisd(size, axis));
    EXPECT_LT((exp_quat(phi).coeffs() - closed.coeffs()).norm(), 3e-16) << size;
    EXPECT_LT((log_quat(closed) - phi).norm(), 3e-16) << size;
    const Mat3 K = skew(phi);
    const Mat3 Jr = Mat3::Identity() - (1.0 - std::cos(size)) / (size * size) * K +
                    (size - std::sin(size)) / (size * size * size) * K * K;
    EXPECT_LT((right_jacobian(phi) - Jr).norm(), 1e-14) << size;  // the closed form's own cancellation
  }
}

TEST(So3, RenormalizedQuaternionHasUnitNorm) {
  const Quat q = exp_quat(Vec3(0.3, -0.2, 0.7));
  for (const double off : {-1e-8, 0.0, 1e-8})
    EXPECT_LT((renormalized(Quat((1.0 + off) * q.coeffs())).coeffs() - q.coeffs()).norm(), 4e-16) << off;
}

TEST(So3, RightJacobianIsTheDerivativeOfTheExponential) {
  for (const double size : {1e-6, 0.05, 0.3, 2.5}) {
    const Vec3 phi = size * Vec3(0.3, 1, -0.7).normalized();
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = h * Vec3::Unit(k);
      const Vec3 column = (log_quat(exp_quat(phi).conjugate() * exp_quat(phi + d)) -
                           log_quat(exp_quat(phi).conjugate() * exp_quat(phi - d))) /
                          (2 * h);
      EXPECT_LT((column - right_jacobian(phi).col(k)).norm(), 1e-8) << size;
    }
  }
}

}  // namespace
}  // namespace stillpoint

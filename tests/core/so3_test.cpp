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

TEST(So3, RightJacobianIsTheDerivativeOfTheExponential) {
  for (const double size : {1e-6, 0.3, 2.5}) {
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

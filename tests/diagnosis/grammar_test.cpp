/// Which factors the grammar makes of the drivers at hand.
#include "diagnosis/discovery/grammar.h"

#include <gmock/gmock.h>

#include <cmath>

namespace stillpoint::diag {
namespace {

/// Five attitudes, in each of which the force departs from gravity along itself by so many m/s^2.
laws::Columns turning_with(double departure_mps2) {
  laws::Columns out;
  out.t_s = Eigen::VectorXd::LinSpaced(500, 0.0, 49.9);
  Eigen::MatrixXd f(500, 3), w = Eigen::MatrixXd::Zero(500, 3);
  for (Eigen::Index i = 0; i < 500; ++i) {
    const double turn = static_cast<double>(i / 100);
    const double size = 9.81 + departure_mps2 * std::sin(0.7 * static_cast<double>(i));
    f.row(i) = size * Eigen::RowVector3d(std::sin(turn), 0.0, std::cos(turn));
  }
  out.values["f"] = f;
  out.values["w"] = w;
  return out;
}

TEST(Grammar, TheSizeOfAForceThatIsGravityAloneIsNoFactor) {
  EXPECT_THAT(scalar_factors(turning_with(0.04)), testing::Not(testing::Contains("(norm(f) - 9.81)")));
  EXPECT_THAT(scalar_factors(turning_with(1.0)), testing::Contains("(norm(f) - 9.81)"));
}

}  // namespace
}  // namespace stillpoint::diag

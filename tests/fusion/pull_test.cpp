/// Where two witnesses disagree and nobody knows which is wrong, the attitude may be off by what one of them says.
#include <cmath>

#include "core/units.h"
#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

/// Three degrees a second about the vertical from a rest on, which a rest detector takes for an offset.
TEST(Pull, ATurntableThatIsCalledRestLeavesNoSureHeading) {
  constexpr double kTurn_radps = 0.05;
  AttitudeFilter filter;
  double turned_rad = 0.0;
  Coverage coverage;
  for (int i = 0; i < 8000; ++i) {
    const double rate = i > 1000 && i < 5000 ? kTurn_radps : 0.0;
    turned_rad += 0.01 * rate;
    const double noise = 1e-3 * ((i * 7919) % 101 / 50.0 - 1.0);
    CalibratedSample s;
    s.t_ns = 10'000'000LL * (i + 1);
    s.has = kAcc | kGyr;
    s.acc_mps2 = {noise, -noise, kStandardGravity_mps2 + noise};
    s.gyr_radps = {noise, -noise, rate + noise};
    const AttitudeEstimate e = filter.step(s, true);
    if (i < 200) continue;
    const double error =
        test::error_world(Quat(Eigen::AngleAxisd(turned_rad, Vec3::UnitZ())), quat(e.q_world_body)).z();
    coverage.note(std::abs(error) < 3.0 * e.sigma_yaw_rad);
  }
  EXPECT_GT(coverage.share(), 0.98);
}

}  // namespace
}  // namespace stillpoint::fusion

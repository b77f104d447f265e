/// What the tests of the filter ask of every estimate.
#pragma once
#include <gtest/gtest.h>

#include "fusion/attitude_filter.h"
#include "tests/fusion/random_motion.h"

namespace stillpoint::fusion {

inline double tilt_rad(const Vec3& error) { return error.head<2>().norm(); }

/// How many of the estimates kept what they stated.
struct Coverage {
  int inside = 0, judged = 0;
  void note(bool within) {
    inside += within;
    ++judged;
  }
  [[nodiscard]] double share() const { return static_cast<double>(inside) / judged; }
};

inline void expect_valid(const AttitudeEstimate& e) {
  ASSERT_NEAR(quat(e.q_world_body).norm(), 1.0, 1e-12);
  ASSERT_TRUE(mat(e.covariance_world_rad2).allFinite());
  ASSERT_GE(e.sigma_roll_rad, 0.0);
  ASSERT_GE(e.sigma_yaw_rad, 0.0);
  ASSERT_TRUE(vec(e.rate_body_radps).allFinite());
}

}  // namespace stillpoint::fusion

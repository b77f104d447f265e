/// Forward and backward over a whole recording: pipeline/smooth.h.
#include "pipeline/smooth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/pipeline/simulated_run.h"

namespace stillpoint::pipeline {
namespace {

fusion::AttitudeEstimate estimate(const Quat& q, const Vec3& sd_rad, HeadingReference heading) {
  fusion::AttitudeEstimate e;
  e.q_world_body = {q.w(), q.x(), q.y(), q.z()};
  e.covariance_world_rad2 = array(Mat3(sd_rad.cwiseAbs2().asDiagonal()));
  e.heading = heading;
  return e;
}

Vec3 turned(const fusion::AttitudeEstimate& e) { return log_quat(quat(e.q_world_body)); }

TEST(Smooth, TwoOfEqualWordMeetHalfway) {
  const Vec3 sd(0.02, 0.02, 0.02);
  const auto out = fused(estimate(exp_quat(Vec3(0.02, 0.0, -0.01)), sd, HeadingReference::kMagnetic),
                         estimate(exp_quat(Vec3(-0.01, 0.03, 0.02)), sd, HeadingReference::kMagnetic));
  EXPECT_NEAR((turned(out) - Vec3(0.005, 0.015, 0.005)).norm(), 0.0, 5e-4);
  EXPECT_EQ(out.heading, HeadingReference::kMagnetic);
}

TEST(Smooth, TheSurerOfTheTwoCountsByItsVariance) {
  const auto out = fused(estimate(Quat::Identity(), Vec3(0.01, 0.01, 0.01), HeadingReference::kMagnetic),
                         estimate(exp_quat(Vec3(0.1, 0.0, 0.0)), Vec3(0.03, 0.03, 0.03), HeadingReference::kMagnetic));
  EXPECT_NEAR(turned(out).x(), 0.1 * 1e-4 / (1e-4 + 9e-4), 1e-4);
}

TEST(Smooth, ABackwardThatKnowsNoHeadingHelpsTheTiltAlone) {
  const Quat backward = Eigen::AngleAxisd(2.0, Vec3::UnitZ()) * exp_quat(Vec3(0.04, 0.0, 0.0));
  const Vec3 sd(0.02, 0.02, 0.02);
  const auto out = fused(estimate(exp_quat(Vec3(0.0, 0.0, 0.3)), sd, HeadingReference::kMagnetic),
                         estimate(backward, sd, HeadingReference::kRelative));
  const Vec3 ahead = quat(out.q_world_body) * Vec3::UnitX();
  EXPECT_NEAR(std::atan2(ahead.y(), ahead.x()), 0.3, 2e-3);
  EXPECT_NEAR(out.sigma_yaw_rad, 0.02, 1e-6);
  const Vec3 up = quat(out.q_world_body).conjugate() * Vec3::UnitZ();
  EXPECT_NEAR(std::hypot(up.x(), up.y()), 0.02, 2e-3);
}

constexpr char kHandInRoom[] =
    "rate_hz: 100\n"
    "accelerometer: {noise_mps2: 0.03, bias: [0.02, -0.01, 0.03], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "gyroscope: {noise_radps: 0.004, bias: [0.03, -0.02, 0.015], matrix: [[1.003, 0, 0.002], [0, 0.996, 0], [0, 0, "
    "1]]}\n"
    "magnetometer: {noise_uT: 0.6, bias: [6, -4, 3], matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}\n"
    "motion: {kind: hand, duration_s: 120}\n";

struct Judged {
  double tilt2 = 0.0, heading2 = 0.0;
  std::size_t rows = 0, tilt_inside = 0, heading_inside = 0;

  void add(const sim::SimulatedSample& truth, const Processed& p) {
    const Vec3 error = test::world_error(truth, p);
    const Mat3 P = mat(p.attitude.covariance_world_rad2);
    tilt2 += error.head<2>().squaredNorm();
    heading2 += error.z() * error.z();
    // Of two components 11.8 holds as many as three deviations of one.
    tilt_inside += error.head<2>().dot(P.topLeftCorner<2, 2>().inverse() * error.head<2>()) < 11.8;
    heading_inside += std::abs(error.z()) < 3.0 * std::sqrt(P(2, 2));
    ++rows;
  }
  [[nodiscard]] double share(std::size_t inside) const {
    return static_cast<double>(inside) / static_cast<double>(rows);
  }
};

/// One recording of a hand, as it is estimated on the way and from both sides.
struct BothWays {
  Judged causal, smoothed;
  std::vector<Processed> rows;
};

BothWays both_ways(std::uint64_t seed) {
  std::vector<sim::SimulatedSample> truths;
  BothWays out;
  test::run_simulated(kHandInRoom, {}, seed, [&](const sim::SimulatedSample& truth, const Processed& p) {
    truths.push_back(truth);
    out.causal.add(truth, p);
  });
  calib::OnlineCalibrator calibrator({}, {});
  const auto sample = [&](std::size_t row) { return truths[row].sample; };
  out.rows = smooth(truths.size(), sample, {}, calibrator).rows;
  for (std::size_t row = 0; row < out.rows.size(); ++row) out.smoothed.add(truths[row], out.rows[row]);
  return out;
}

TEST(Smooth, AHandsMotionIsBetterKnownAfterwardsAndStillCovered) {
  Judged causal, smoothed;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const BothWays both = both_ways(seed);
    ASSERT_EQ(both.smoothed.rows, both.causal.rows);
    EXPECT_LT(both.smoothed.heading2, 0.2 * both.causal.heading2) << seed;
    EXPECT_LT(both.smoothed.tilt2, 2.0 * both.causal.tilt2) << seed;  // both are at what the calibration leaves
    EXPECT_GT(both.smoothed.share(both.smoothed.tilt_inside), 0.98) << seed;
    EXPECT_GT(both.smoothed.share(both.smoothed.heading_inside), 0.98) << seed;
  }
}

/// The last calibration holds the magnet as well: what came before it is not judged by that.
TEST(Smooth, AMagnetThatComesLateLeavesTheBeginning) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::vector<sim::SimulatedSample> truths;
    test::run_simulated(kHandInRoom, {}, seed, [&](const sim::SimulatedSample& truth, const Processed&) {
      truths.push_back(truth);
      if (truths.size() > 8000) vec(truths.back().sample.mag_uT) += Vec3(60.0, 80.0, -70.0);
    });
    calib::OnlineCalibrator calibrator({}, {});
    const auto rows = smooth(
                          truths.size(), [&](std::size_t row) { return truths[row].sample; }, {}, calibrator)
                          .rows;
    ASSERT_EQ(rows.size(), truths.size());
    Judged before;
    for (std::size_t row = 3000; row < 7500; ++row) before.add(truths[row], rows[row]);
    const double heading_deg = kDegPerRad * std::sqrt(before.heading2 / static_cast<double>(before.rows));
    EXPECT_LT(heading_deg, 6.0) << seed;
    EXPECT_GT(before.share(before.heading_inside), 0.98) << seed;
  }
}

TEST(Smooth, TwoRunsAreTheSameToTheBit) {
  const BothWays a = both_ways(4), b = both_ways(4);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t row = 0; row < a.rows.size(); ++row)
    ASSERT_EQ(a.rows[row].attitude.q_world_body, b.rows[row].attitude.q_world_body) << row;
}

TEST(Smooth, OfNothingComesNothing) {
  calib::OnlineCalibrator calibrator({}, {});
  EXPECT_TRUE(smooth(
                  0, [](std::size_t) { return RawSample{}; }, {}, calibrator)
                  .rows.empty());
}

}  // namespace
}  // namespace stillpoint::pipeline

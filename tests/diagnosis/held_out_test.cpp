/// What is held out is judged by all of the rest, with what the rest leaves open.
#include <gmock/gmock.h>

#include <Eigen/LU>
#include <random>

#include "diagnosis/reference/blocks_left_out.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kRows = 600, kBlock = 200;
constexpr double kPrior = 1e-6;  // of what all rows say

Target target_of(const Series3& residual) {
  Target t;
  t.layout.n = kRows, t.layout.order = 0;
  t.layout.segments = {{0, kRows, 0}};
  t.layout.present = t.layout.counts = Eigen::ArrayXd::Ones(kRows);
  t.residual = residual;
  t.nuisance = Eigen::MatrixXd::Ones(kRows, 1);
  return t;
}

/// Logarithm of the density of the rows in the middle, but for 2 pi: a normal distribution about what the others tell.
double density_of_the_middle(const Eigen::MatrixXd& X, const Series& y) {
  Eigen::MatrixXd outer(kRows - kBlock, X.cols());
  outer << X.topRows(kBlock), X.bottomRows(kBlock);
  Series read(kRows - kBlock);
  read << y.head(kBlock), y.tail(kBlock);
  Eigen::MatrixXd information = outer.transpose() * outer;
  information.diagonal() += kPrior * (X.transpose() * X).diagonal();
  const Eigen::MatrixXd own = X.middleRows(kBlock, kBlock), covariance = information.inverse();
  const Eigen::VectorXd off = y.segment(kBlock, kBlock) - own * (covariance * (outer.transpose() * read));
  const Eigen::MatrixXd spread = Eigen::MatrixXd::Identity(kBlock, kBlock) + own * covariance * own.transpose();
  return -0.5 * (off.dot(spread.ldlt().solve(off)) + std::log(spread.determinant()));
}

TEST(BlocksLeftOut, HaveTheDensityOfANormalDistributionAboutWhatTheOthersTell) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Series3 residual = Series3::NullaryExpr(kRows, 3, [&] { return 0.5 * normal(random); });
  Series3 law = Series3::Zero(kRows, 3);  // what the outer blocks hardly tell
  for (Eigen::Index i = 0; i < kRows; ++i)
    law(i, 0) = (i / kBlock == 1 ? 3.0 : 0.03) * std::sin(0.1 * static_cast<double>(i));
  const Target t = target_of(residual);
  const NoiseModel noise(t.layout, 2.0 * residual);  // more than there is, so that the readings are not doubted
  const LeftOut out = blocks_left_out(t, {{-1, law}}, noise, kBlock);
  double expected = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd X(kRows, axis == 0 ? 2 : 1);
    X.col(0) = noise.whiten(t.layout, t.nuisance.col(0), axis);
    if (axis == 0) X.col(1) = noise.whiten(t.layout, law.col(0), 0);
    expected += density_of_the_middle(X, noise.whiten(t.layout, residual.col(axis), axis));
  }
  ASSERT_EQ(out.nats.size(), 3);
  EXPECT_NEAR(out.nats[1], expected, 1e-6);
}

/// A law that is true removes all that coefficients from elsewhere can: what those leave beyond the best ones is known.
TEST(BlocksLeftOut, CostWhatTheCoefficientsOfOthersAreKnownTo) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Series3 noise_alone = Series3::NullaryExpr(kRows, 3, [&] { return normal(random); });
  Series3 law = Series3::Zero(kRows, 3);
  for (Eigen::Index i = 0; i < kRows; ++i)
    law(i, 0) = (i / kBlock == 1 ? 3.0 : 0.3) * std::sin(0.1 * static_cast<double>(i));
  const Target t = target_of(noise_alone);
  const NoiseModel noise(t.layout, noise_alone);
  const Eigen::VectorXd excess = excess_of_others(t, {{-1, law}}, noise, kBlock, {0, 1, 0});
  ASSERT_EQ(excess.size(), 2);
  double expected = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd X(kRows, axis == 0 ? 2 : 1);
    X.col(0) = noise.whiten(t.layout, t.nuisance.col(0), axis);
    if (axis == 0) X.col(1) = noise.whiten(t.layout, law.col(0), 0);
    const Eigen::MatrixXd all = X.transpose() * X,
                          own = X.middleRows(kBlock, kBlock).transpose() * X.middleRows(kBlock, kBlock);
    expected += (own * (all.inverse() + (all - own).inverse())).trace();
  }
  EXPECT_NEAR(excess[1], expected, 1e-3 * expected);
  EXPECT_GT(excess[1], 5.0 * excess[0]) << "the law is told by the block in the middle";
}

/// Half of six turns, each about one axis, tells the matrix and the asymmetry hardly from each other, and predicts the
/// other half by neither.
TEST(HeldOut, AFewTurnsBetweenPosesTellAnAsymmetry) {
  const auto config = test::parsed(
      "rate_hz: 100\naccelerometer: {noise_mps2: 0.007}\ngyroscope: {noise_radps: 0.0005}\n"
      "magnetometer: {noise_uT: 0.05}\nmotion: {kind: rest_poses, duration_s: 30}\nreference: {kind: exact}\n");
  for (const std::uint64_t seed : {1, 4}) {
    const Answer answer = diagnose(test::record(config, "gyr_asym", {{"k", {0.0013, 0.0013, -0.001}}}, seed), config);
    EXPECT_THAT(test::names(answer), testing::ElementsAre("gyr_asym")) << seed;
  }
}

}  // namespace
}  // namespace stillpoint::diag

/// What is straight between knots stands for the whitened columns themselves.
#include "diagnosis/reference/slow_columns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace stillpoint::diag {
namespace {

/// A minute at 50 Hz behind a camera: rests of their own regime, lost rows, a noise with a memory of its own in each.
struct Case {
  Signals s;
  Layout layout;
  Series3 leftover;
  Eigen::MatrixXd columns;

  Case() {
    s.n = 3000;
    s.dt_s = 0.02;
    s.exact_reference = false;
    s.rest.assign(static_cast<std::size_t>(s.n), 0);
    for (std::size_t i = 0; i < s.rest.size(); ++i) s.rest[i] = i / 400 % 3 == 2;
    for (const Sensor k : {kAcc, kGyr, kMag}) s.muted[k].assign(static_cast<std::size_t>(s.n), 0);
    for (auto& muted : s.muted) muted[1000] = muted[1001] = muted[2500] = 1;
    layout = make_layout(s, kAcc);
    leftover = Series3::Zero(s.n, 3);
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (Eigen::Index i = 1; i < s.n; ++i)
      for (int axis = 0; axis < 3; ++axis)
        leftover(i, axis) =
            (s.rest[static_cast<std::size_t>(i)] ? 0.3 : 0.9) * leftover(i - 1, axis) + (1.0 + axis) * normal(random);
    columns.resize(s.n, 15);
    for (Eigen::Index i = 0; i < s.n; ++i)
      for (Eigen::Index k = 0; k < columns.cols(); ++k)
        columns(i, k) = std::cos(std::numbers::pi * static_cast<double>((k + 1) * i) / static_cast<double>(s.n));
  }
};

TEST(SlowColumns, AreTheWhitenedOnesWithinAHundredth) {
  const Case c;
  ASSERT_EQ(c.layout.regimes, 2);
  const NoiseModel noise(c.layout, c.leftover);
  for (int axis = 0; axis < 3; ++axis) {
    const SlowColumns slow(c.layout, c.columns, noise, axis);
    Eigen::MatrixXd exact(c.s.n, c.columns.cols());
    for (Eigen::Index k = 0; k < exact.cols(); ++k) exact.col(k) = noise.whiten(c.layout, c.columns.col(k), axis);
    const auto one = Eigen::MatrixXd::Identity(slow.cols(), slow.cols());
    EXPECT_LT((slow.times(one) - exact).norm(), 0.01 * exact.norm());
    EXPECT_LT((slow.gram() - exact.transpose() * exact).norm(), 0.01 * (exact.transpose() * exact).norm());
    const Eigen::MatrixXd whitened = noise.whiten(c.layout, c.leftover.col(axis), axis);
    EXPECT_LT((slow.products(whitened) - exact.transpose() * whitened).norm(),
              0.01 * exact.norm() * whitened.norm() / std::sqrt(c.layout.used()));
    // Among themselves they are one matrix to the last digit: a normal matrix of them stays positive.
    EXPECT_LT((slow.gram() - slow.times(one).transpose() * slow.times(one)).norm(), 1e-12 * slow.gram().norm());
    EXPECT_LT((slow.products(whitened) - slow.times(one).transpose() * whitened).norm(), 1e-9 * whitened.norm());
  }
}

}  // namespace
}  // namespace stillpoint::diag

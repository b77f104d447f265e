#include "calib_online/moments.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "calib_online/offline/ellipsoid_fit.h"

namespace stillpoint::calib {
namespace {

std::vector<Vec3> twelve_bit_readings(int n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vec3> out;
  for (int k = 0; k < n; ++k) {
    const Vec3 u = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 y = Vec3(2290, 2310, 2305) + Vec3(495, 505, 500).cwiseProduct(u) +
                   Vec3(normal(random), normal(random), normal(random));
    out.push_back(y.array().round());
  }
  return out;
}

template <class Sums>
Sums sums(const std::vector<Vec3>& y, const Vec3& c0, double r0) {
  Sums m;
  for (const Vec3& v : y) {
    if constexpr (std::is_same_v<Sums, Moments>)
      m.add(Vec3((v - c0) / r0));
    else
      m.add(Eigen::Vector3f(((v - c0) / r0).cast<float>()));
  }
  return m;
}

/// The general fit from a batch normal matrix, built here without the moments.
Vec3 batch_centre(const std::vector<Vec3>& y, const Vec3& c0, double r0) {
  Moments::Mat10 P = Moments::Mat10::Zero();
  for (const Vec3& v : y) {
    Eigen::Matrix<double, 10, 1> d;
    d << quadric_terms(Vec3((v - c0) / r0)), 1.0;
    P += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Moments::Mat10> eigen(P);
  const Eigen::Matrix<double, 10, 1> p = eigen.eigenvectors().col(0);
  return c0 + r0 * ellipsoid(Vec9(p.head<9>() / -p[9]))->centre;
}

TEST(Moments, GiveTheBatchFitToNineDigits) {
  const Vec3 c0(2300, 2300, 2300);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto y = twelve_bit_readings(2000, seed);
    const Vec3 by_sums = c0 + 500 * general_fit(sums<Moments>(y, c0, 500)).ellipsoid.centre;
    EXPECT_LT((by_sums - batch_centre(y, c0, 500)).norm(), 1e-9) << seed;  // counts
  }
}

TEST(CompensatedMoments, GiveTheBatchFitInSinglePrecision) {
  const Vec3 c0(2300, 2300, 2300);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto y = twelve_bit_readings(2000, seed);
    const Vec3 by_floats = c0 + 500 * general_fit(sums<CompensatedMoments>(y, c0, 500).widened()).ellipsoid.centre;
    // Counts. Plain sums reach 2e-3; the goal is 1e-3.
    EXPECT_LT((by_floats - batch_centre(y, c0, 500)).norm(), 1e-5) << seed;
  }
}

TEST(CompensatedMoments, RawCountsInSinglePrecisionAreUseless) {
  // Why the sums are centred by the prior: the same readings, scaled but not centred, give no ellipsoid.
  const auto y = twelve_bit_readings(2000, 1);
  const auto fit = general_fit(sums<CompensatedMoments>(y, Vec3::Zero(), 4096).widened());
  const Vec3 batch = batch_centre(y, Vec3(2300, 2300, 2300), 500);
  EXPECT_TRUE(fit.status != FitStatus::kOk || (4096 * fit.ellipsoid.centre - batch).norm() > 0.5);
}

TEST(CompensatedMoments, ForgetAsTheDoublesDo) {
  const Vec3 c0(2300, 2300, 2300);
  CompensatedMoments narrow;
  Moments wide;
  for (const Vec3& v : twelve_bit_readings(5000, 3)) {
    const Eigen::Vector3f x = ((v - c0) / 500.0).cast<float>();
    narrow.forget(0.998F);
    narrow.add(x);
    wide.forget(static_cast<double>(0.998F));
    wide.add(x.cast<double>());
  }
  const auto got = narrow.widened().sums();
  for (std::size_t k = 0; k < got.size(); ++k) EXPECT_NEAR(got[k], wide.sums()[k], 3e-5) << k;  // of sums up to 500
}

TEST(Moments, TranslateScaleMergeAndRemoveExactly) {
  const auto y = twelve_bit_readings(300, 2);
  const Vec3 c0(2300, 2300, 2300), d(0.3, -0.2, 0.1), s(0.9, 1.2, 1.1);
  Moments straight, moved, first, second;
  for (std::size_t k = 0; k < y.size(); ++k) {
    const Vec3 x = (y[k] - c0) / 500.0;
    straight.add(Vec3((x - d).cwiseQuotient(s)));
    moved.add(x);
    (k < 100 ? first : second).add(x);
  }
  const Moments through = moved.translated(d).scaled(s);
  Moments together = first;
  together.merge(second);
  Moments back = together;
  back.remove(second);
  for (std::size_t k = 0; k < 35; ++k) {
    EXPECT_NEAR(through.sums()[k], straight.sums()[k], 1e-10);
    EXPECT_NEAR(together.sums()[k], moved.sums()[k], 1e-10);
    EXPECT_NEAR(back.sums()[k], first.sums()[k], 1e-10);
  }
}

TEST(Moments, AdjustedSumsHaveTheNoiseFreeMean) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Vec3 x0(0.4, -0.7, 0.6);
  Mat3 root;
  root << 0.2, 0, 0, 0.1, 0.15, 0, -0.05, 0.08, 0.12;
  const Mat3 C = root * root.transpose();
  Moments clean, noisy, sequential;
  clean.add(x0);
  constexpr int n = 400000;
  for (int k = 0; k < n; ++k) {
    const Vec3 x = x0 + root * Vec3(normal(random), normal(random), normal(random));
    noisy.add(x, 1.0 / n);
    if (k < 1000) sequential.add_adjusted(x, C);
  }
  const Moments adjusted = noisy.adjusted(C);
  double raw_error = 0.0;
  for (std::size_t k = 0; k < 35; ++k) {
    EXPECT_NEAR(adjusted.sums()[k], clean.sums()[k], 4e-3)
        << k;  // Monte Carlo: sd of a fourth power over root n is 1e-3
    raw_error = std::max(raw_error, std::abs(noisy.sums()[k] - clean.sums()[k]));
  }
  EXPECT_GT(raw_error, 0.05);  // without the adjustment the sums are off by the noise
  EXPECT_EQ(sequential.weight(), 1000.0);
}

}  // namespace
}  // namespace stillpoint::calib

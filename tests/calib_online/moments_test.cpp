#include "calib_online/moments.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>
#include <random>

#include "calib_online/ellipsoid_fit.h"

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

template <class T>
BasicMoments<T> sums(const std::vector<Vec3>& y, const Vec3& c0, double r0) {
  BasicMoments<T> m;
  for (const Vec3& v : y) m.add(Eigen::Matrix<T, 3, 1>(((v - c0) / r0).template cast<T>()));
  return m;
}

Moments in_double(const BasicMoments<float>& f) {
  // The fit is done in double: only the running sum is of single precision.
  Moments m;
  auto raw = m.sums();
  for (std::size_t k = 0; k < raw.size(); ++k) raw[k] = static_cast<double>(f.sums()[k]);
  std::memcpy(static_cast<void*>(&m), raw.data(), sizeof raw);
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

TEST(Moments, GiveTheBatchFitToNineDigitsAndInSinglePrecisionToThree) {
  const Vec3 c0(2300, 2300, 2300);
  const auto y = twelve_bit_readings(2000, 1);
  const Vec3 batch = batch_centre(y, c0, 500);
  const Vec3 by_sums = c0 + 500 * general_fit(sums<double>(y, c0, 500)).ellipsoid.centre;
  const Vec3 by_floats = c0 + 500 * general_fit(in_double(sums<float>(y, c0, 500))).ellipsoid.centre;
  EXPECT_LT((by_sums - batch).norm(), 1e-9);    // counts
  EXPECT_LT((by_floats - batch).norm(), 2e-3);  // counts; largest of several seeds is 1e-3 to 2e-3
}

TEST(Moments, RawCountsInSinglePrecisionAreUseless) {
  const auto y = twelve_bit_readings(2000, 1);
  const auto fit = general_fit(in_double(sums<float>(y, Vec3::Zero(), 4096)));
  const Vec3 batch = batch_centre(y, Vec3(2300, 2300, 2300), 500);
  const bool lost = fit.status != FitStatus::kOk || (4096 * fit.ellipsoid.centre - batch).norm() > 0.5;
  EXPECT_TRUE(lost);  // why the sums are centred by the prior
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

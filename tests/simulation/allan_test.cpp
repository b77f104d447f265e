#include "simulation/allan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stillpoint::sim {
namespace {

constexpr double kDt_s = 0.01;

std::vector<double> white(std::size_t n, double sd, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, sd);
  std::vector<double> x(n);
  for (double& v : x) v = normal(random);
  return x;
}

TEST(Allan, WhiteNoiseFallsWithTheSquareRootOfTheAveragingTime) {
  const auto points = allan_deviation(white(400'000, 0.5, 1), kDt_s);
  ASSERT_GT(points.size(), 30U);
  int inside = 0;
  for (const auto& p : points) {
    const double expected = 0.5 * std::sqrt(kDt_s / p.tau_s);
    inside += std::abs(p.deviation / expected - 1.0) < 1.96 * p.relative_error ? 1 : 0;
  }
  EXPECT_GE(inside, static_cast<int>(0.9 * static_cast<double>(points.size())));
}

TEST(Allan, AgreesWithTheDefinitionOnAHandfulOfNumbers) {
  // At one sample the Allan variance is half the mean squared difference of neighbours.
  const std::vector<double> x{1, 2, 4, 3, 3, 5, 4, 4, 2};
  const auto points = allan_deviation(x, 1.0);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].deviation, std::sqrt((1 + 4 + 1 + 0 + 4 + 1 + 0 + 4) / 8.0 / 2.0), 1e-12);
}

TEST(Allan, RecoversWhiteNoiseAndRandomWalkWithinTheirErrors) {
  int n_inside = 0, k_inside = 0;
  constexpr int kSeeds = 20;
  constexpr double kN = 0.05, kK = 0.004;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    auto x = white(200'000, kN / std::sqrt(kDt_s), seed);
    const auto steps = white(x.size(), kK * std::sqrt(kDt_s), 1000 + seed);
    double walk = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += walk += steps[i];
    const NoiseTerms terms = fit_noise_terms(allan_deviation(x, kDt_s));
    n_inside += std::abs(terms.value[kWhite] - kN) < 3 * terms.standard_error[kWhite] + 0.01 * kN ? 1 : 0;
    k_inside += std::abs(terms.value[kRandomWalk] - kK) < 3 * terms.standard_error[kRandomWalk] ? 1 : 0;
  }
  EXPECT_GE(n_inside, 17);
  EXPECT_GE(k_inside, 17);
}

TEST(Allan, ClaimsNoTermThatIsNotThere) {
  int walks = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const NoiseTerms terms = fit_noise_terms(allan_deviation(white(100'000, 1.0, seed), kDt_s));
    EXPECT_NEAR(terms.value[kWhite], 0.1, 0.002);
    walks += terms.value[kRandomWalk] > 0 ? 1 : 0;
    if (terms.value[kRandomWalk] == 0) {
      EXPECT_GT(terms.upper_limit[kRandomWalk], 0.0);
    }
  }
  EXPECT_LE(walks, 4);
}

TEST(Allan, SaysNothingOfARecordTooShort) { EXPECT_TRUE(allan_deviation(white(8, 1.0, 1), kDt_s).empty()); }

}  // namespace
}  // namespace stillpoint::sim

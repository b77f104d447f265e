/// How long the noise model's filter is where samples are missing, and what it is not fitted to.
#include "diagnosis/reference/noise_model.h"

#include <gtest/gtest.h>

#include <random>

namespace stillpoint::diag {
namespace {

/// Signals of which all but every `every`-th sample of the sensors are there.
Signals with_holes(Eigen::Index every, bool in_all_sensors) {
  Signals s;
  s.n = 12'000;
  s.dt_s = 0.01;
  s.rest.assign(static_cast<std::size_t>(s.n), 0);
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    s.muted[k].assign(static_cast<std::size_t>(s.n), 0);
    for (Eigen::Index i = 0; i < s.n; i += every)
      if (in_all_sensors || k == kMag) s.muted[k][static_cast<std::size_t>(i)] = 1;
  }
  return s;
}

TEST(NoiseModel, IsShorterWhereRowsAreLostAndWithoutMemoryWhereOneSensorsValuesAreSetAside) {
  EXPECT_EQ(make_layout(with_holes(100, true), kMag).order, kAutoregressiveOrder) << "few holes";
  EXPECT_EQ(make_layout(with_holes(100, false), kMag).order, kAutoregressiveOrder) << "few holes";
  const Layout lost = make_layout(with_holes(12, true), kMag);
  EXPECT_EQ(lost.order, 4);
  EXPECT_EQ(lost.used(), 7000) << "of each 11 samples between two lost rows the first four are history";
  const Layout held = make_layout(with_holes(12, false), kMag);
  EXPECT_EQ(held.order, 0);
  EXPECT_EQ(held.used(), 11'000);
}

TEST(NoiseModel, RemembersLongerWhatIsDerivedFromACamera) {
  Signals s = with_holes(20'000, true);
  const auto order = [&s](Sensor k, double dt_s) {
    s.dt_s = dt_s;
    return make_layout(s, k).order;
  };
  EXPECT_EQ(order(kAcc, 0.005), 64);
  EXPECT_EQ(order(kGyr, 0.01), 32);
  EXPECT_EQ(order(kGyr, 0.02), kAutoregressiveOrder);
  EXPECT_EQ(order(kMag, 0.005), kAutoregressiveOrder) << "of attitudes themselves";
  s.exact_reference = true;
  EXPECT_EQ(order(kGyr, 0.005), kAutoregressiveOrder);
}

TEST(NoiseModel, LeavesOutTheBlocksThatHoldMoreThanNoise) {
  Signals s = with_holes(20'000, true);
  const Layout all = make_layout(s, kAcc);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Series3 leftover(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) leftover.row(i) << normal(random), normal(random), normal(random);
  EXPECT_EQ(without_bursts(all, leftover).used(), all.used()) << "alike throughout";
  leftover.middleRows(3000, 600) *= 5.0;  // 30 to 36 s: three blocks of two seconds
  const Layout quiet = without_bursts(all, leftover);
  EXPECT_EQ(quiet.present.segment(3000, 600).sum(), 0.0);
  EXPECT_EQ(quiet.present.sum(), all.present.sum() - 600.0);
  EXPECT_EQ(quiet.counts.segment(3600, kAutoregressiveOrder).sum(), 0.0) << "its history is not there";
}

}  // namespace
}  // namespace stillpoint::diag

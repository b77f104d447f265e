#include "calib_online/temperature_cells.h"

#include <gtest/gtest.h>

#include <random>

#include "calib_online/temperature_filter.h"

namespace stillpoint::calib {
namespace {

constexpr double kFloor = 3e-4;  // of g, of a window's norm

/// A unit sphere whose centre moves with temperature: 20 mg at 25 degC, 0.8 mg/K along x, -0.5 along z.
Vec3 centre(double temp_degC) { return Vec3(0.02, -0.01, 0.015) + (temp_degC - 25.0) * Vec3(8e-4, 0.0, -5e-4); }

struct Wear {
  TemperatureCells cells;
  std::mt19937_64 random{3};
  std::normal_distribution<double> normal;
  Vec3 direction() { return Vec3(normal(random), normal(random), normal(random)).normalized(); }
  void rest(const Vec3& u, double temp_degC) {
    const Vec3 noise = kFloor * Vec3(normal(random), normal(random), normal(random));
    cells.add(u + centre(temp_degC) + noise, Mat3(kFloor * kFloor * Mat3::Identity()), temp_degC);
  }
  void rest_everywhere(double temp_degC, int windows) {
    for (int k = 0; k < windows; ++k) rest(direction(), temp_degC);
  }
};

TemperatureCells::Prior prior() {
  TemperatureCells::Prior p;
  p.variance.head<9>().setConstant(4.0 * 0.02 * 0.02);
  p.variance.segment<9>(9).setConstant(4.0 * 0.02 * 0.02);
  p.variance.tail<3>().setConstant(4.0 * 0.005 * 0.005);
  p.local_variance = 4.0 * 5e-4 * 5e-4;
  p.window_variance = 4.0 * kFloor * kFloor;
  return p;
}

double centre_error(const TemperatureCells& cells, double temp_degC) {
  const auto e = cells.at(temp_degC, prior());
  EXPECT_TRUE(e.valid);
  return (ellipsoid(e.p)->centre - centre(temp_degC)).norm();
}

TEST(TemperatureCells, KnowNothingButThePriorAtFirst) {
  const auto e = TemperatureCells{}.at(10.0, prior());
  ASSERT_TRUE(e.valid);
  EXPECT_LT((e.p - (Vec9() << 1, 1, 1, 0, 0, 0, 0, 0, 0).finished()).norm(), 1e-12);
  const double tau = (10.0 - 25.0) / kTempScale_K;
  EXPECT_NEAR(e.covariance(8, 8), 4 * 0.02 * 0.02 * (1 + tau * tau) + 4 * 0.005 * 0.005 * std::pow(tau, 4), 1e-12);
}

TEST(TemperatureCells, ACellWithOneDirectionInheritsTheOthersFromItsNeighbours) {
  Wear alone, among;
  for (const double temp_degC : {7.0, 12.0, 17.0, 28.0, 33.0}) among.rest_everywhere(temp_degC, 60);
  for (Wear* w : {&alone, &among})
    for (int k = 0; k < 20; ++k) w->rest(Vec3::UnitY(), 22.5);
  EXPECT_GT(centre_error(alone.cells, 22.5), 0.01);  // x and z are still the prior's, 25 mg away
  EXPECT_LT(centre_error(among.cells, 22.5), 1e-3);  // twice what a cell may differ from the polynomial
}

TEST(TemperatureCells, WhatIsFarCountsLess) {
  Wear w;
  for (const double temp_degC : {12.0, 17.0}) w.rest_everywhere(temp_degC, 60);
  const auto sd = [&](double temp_degC) { return std::sqrt(w.cells.at(temp_degC, prior()).covariance(6, 6)); };
  EXPECT_LT(sd(15.0), sd(22.0));
  EXPECT_LT(sd(22.0), sd(45.0));
  EXPECT_GT(sd(45.0), 2.0 * 5e-4);  // never surer than the polynomial is meant to be
}

TEST(TemperatureCells, ComingBackFindsWhatWasLearnt) {
  Wear w;
  for (const double temp_degC : {2.0, 7.0, 40.0}) w.rest_everywhere(temp_degC, 60);
  const Vec9 before = w.cells.at(5.0, prior()).p;
  w.rest_everywhere(40.0, 3000);  // 3000 windows leave 0.2 % of what a cell held before
  EXPECT_LT((w.cells.at(5.0, prior()).p - before).norm(), 5e-4);
  EXPECT_LT(centre_error(w.cells, 5.0), 1e-3);
}

}  // namespace
}  // namespace stillpoint::calib

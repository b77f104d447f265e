/// A line that is switched on for a while, and whether the sensor has it or the reference brings it in.
#include "diagnosis/reference/line_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kRows = 6000;
constexpr double kLineStep_s = 0.01, kLine_Hz = 22.3;

Series3 noise(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Series3 x(kRows, 3);
  for (double& v : x.reshaped()) v = normal(engine);
  return x;
}

Series3 line(Eigen::Index begin, Eigen::Index end) {
  Series3 x = Series3::Zero(kRows, 3);
  for (Eigen::Index i = begin; i < end; ++i)
    x.row(i).setConstant(std::sin(2.0 * std::numbers::pi * kLine_Hz * kLineStep_s * static_cast<double>(i)));
  return x;
}

Signals rows() {
  Signals s;
  s.n = kRows;
  s.dt_s = s.rows.step_s = kLineStep_s;
  s.t_s = Series::LinSpaced(kRows, 0.0, kLineStep_s * (kRows - 1));
  s.muted[kGyr].assign(kRows, 0);
  return s;
}

Layout all_rows() {
  Layout layout;
  layout.n = kRows;
  layout.present = layout.counts = Eigen::ArrayXd::Ones(kRows);
  return layout;
}

/// The line with an amplitude of its own at each time.
template <class Amplitude>
Series3 line_of(const Amplitude& at) {
  Series3 x = line(0, kRows);
  for (Eigen::Index i = 0; i < kRows; ++i) x.row(i) *= at(kLineStep_s * static_cast<double>(i));
  return x;
}

TEST(LineEvidence, ALineThatLastsAWhileIsToldWithItsTimes) {
  const Signals s = rows();
  const Layout layout = all_rows();
  const Window w = stretch_of_line(noise(1) + line(1800, 4200), layout, s.t_s, kLine_Hz, kLineStep_s);
  ASSERT_TRUE(w.local);
  EXPECT_NEAR(static_cast<double>(w.begin), 1800.0, 100.0);
  EXPECT_NEAR(static_cast<double>(w.end), 4200.0, 100.0);
  EXPECT_FALSE(stretch_of_line(noise(2) + line(0, kRows), layout, s.t_s, kLine_Hz, kLineStep_s).local);
}

TEST(LineEvidence, AnEnginesSwellsAndFades) {
  Signals s = rows();
  const auto swelling = [&s](const Series3& reading, const Window& w = {}) {
    s.reading[kGyr] = reading;
    return swells(s, kGyr, w, kLine_Hz);
  };
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Series3 n = noise(seed);
    EXPECT_TRUE(swelling(n + line_of([](double t) { return 1.0 + 0.35 * std::sin(0.9 * t); }))) << seed;
    EXPECT_TRUE(
        swelling(0.3 * n + line_of([](double t) { return t > 18.0 && t < 42.0 ? 1.0 : 0.25; }), {true, 1800, 4200}))
        << seed << ": it idles";
    for (const double size : {0.1, 0.3, 1.0, 10.0}) {
      EXPECT_FALSE(swelling(n + size * line(0, kRows))) << seed << " " << size;
      EXPECT_FALSE(swelling(n + size * line(1820, 4170), {true, 1800, 4200})) << seed << " " << size << ": switched";
    }
  }
}

TEST(LineEvidence, AMachineShakesTheBodyBesideItsLine) {
  Signals s = rows();
  s.noise_sd[kGyr] = 1.0;
  const auto shakes = [&s](const Series3& reading, double frequency_Hz) {
    s.reading[kGyr] = reading;
    return shakes_beside(s, kGyr, {}, frequency_Hz);
  };
  const Series3 slow = (1e3 * (2.0 * s.t_s.array()).sin()).matrix().replicate(1, 3);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    EXPECT_FALSE(shakes(noise(seed) + 5.0 * line(0, kRows) + slow, kLine_Hz)) << seed << ": motion, and a line";
    EXPECT_TRUE(shakes(10.0 * noise(seed) + 5.0 * line(0, kRows), kLine_Hz)) << seed;
    EXPECT_FALSE(shakes(10.0 * noise(seed), 14.0)) << seed << ": a limb moves there, too";
  }
}

TEST(LineEvidence, TheReadingAloneShowsWhatTheSensorHas) {
  Signals s = rows();
  const Series3 residual = noise(3) + line(0, kRows);
  s.reading[kGyr] = residual;
  EXPECT_TRUE(stands_in_reading(s, kGyr, residual, {}, kLine_Hz));
  s.reading[kGyr] = noise(3);
  EXPECT_FALSE(stands_in_reading(s, kGyr, residual, {}, kLine_Hz)) << "the reference brings it in";
  s.reading[kGyr] = residual + 40.0 * noise(4);
  EXPECT_FALSE(stands_in_reading(s, kGyr, residual, {}, kLine_Hz)) << "motion hides the answer";
}

}  // namespace
}  // namespace stillpoint::diag

/// Rows that are not even: loggers stamp them when they come. What differentiates and filters does so at the rows' own
/// times, unless it is the stamps that are wrong.
#include "diagnosis/reference/row_times.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "diagnosis/reference/response.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kMeanStep_s = 0.01, kLate_s = 0.001;

Series uneven(Eigen::Index n, double sd_s) {
  std::mt19937 random(3);
  std::normal_distribution<double> late(0.0, sd_s);
  Series t(n);
  for (Eigen::Index i = 0; i < n; ++i) t[i] = static_cast<double>(i) * kMeanStep_s + late(random);
  return t.array() - t[0];
}

/// Three sines of 3, 5 and 7 Hz, or a derivative of them.
Series3 motion(const Series& t_s, int order = 0) {
  Series3 x(t_s.size(), 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (int a = 0; a < 3; ++a) {
      const double w = 2.0 * M_PI * (3.0 + 2.0 * a);
      x(i, a) = std::pow(w, order) * std::sin(w * t_s[i] + 0.5 * M_PI * order);
    }
  return x;
}

double off(const Series3& x, const Series3& truth) {
  return (x - truth).middleRows(100, x.rows() - 200).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
}

TEST(RowTimes, DerivativesAreThoseAtTheRowsOwnTimes) {
  const Series t = uneven(1000, kLate_s);
  const RowTimes own{kMeanStep_s, t}, even{kMeanStep_s, {}};
  EXPECT_LT(off(derivative(motion(t), own), motion(t, 1)), 1e-6);
  EXPECT_LT(off(second_derivative(motion(t), own), motion(t, 2)), 1e-5);
  EXPECT_GT(off(derivative(motion(t), even), motion(t, 1)), 0.05);
  EXPECT_LT(derivative_error(motion(t), own).middleRows(100, 800).maxCoeff(), 1e-3);
}

TEST(RowTimes, DifferencesOfEvenRowsAreTheSameByEitherWay) {
  const Series t = uneven(400, 0.0);
  const Series3 x = motion(t);
  EXPECT_LT(off(derivative(x, {kMeanStep_s, t}), derivative(x, {kMeanStep_s, {}})), 1e-12);
  EXPECT_LT(off(second_derivative(x, {kMeanStep_s, t}), second_derivative(x, {kMeanStep_s, {}})), 1e-11);
}

TEST(RowTimes, ADelayIsOneOfTime) {
  constexpr double kTau_s = 0.004;
  const Series t = uneven(1000, kLate_s);
  const Series3 late = apply_response(motion(t), {kMeanStep_s, t}, delay_response(kTau_s));
  EXPECT_LT(off(late, motion(t.array() - kTau_s)), 1e-4);
  EXPECT_LT(off(at_times(motion(t), {kMeanStep_s, t}, t.array() - kTau_s, kStencilReach), motion(t.array() - kTau_s)),
            1e-6);
}

TEST(RowTimes, AreTheStampsWhereTheMotionIsSmoothWithThem) {
  const Series t = uneven(1000, kLate_s), even = uneven(1000, 0.0);
  EXPECT_FALSE(times_of_rows(t, kMeanStep_s, motion(t), {}).even());
  EXPECT_TRUE(times_of_rows(t, kMeanStep_s, motion(even), {}).even()) << "the stamps came late, not the rows";
  EXPECT_TRUE(times_of_rows(even, kMeanStep_s, motion(even), {}).even());
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.3);  // a motion of 1 over 1 ms: a tenth of that
  EXPECT_TRUE(
      times_of_rows(t, kMeanStep_s, motion(t).unaryExpr([&](double x) { return x + noise(random); }), {}).even())
      << "noise is as rough with either";
}

/// One row of twenty, each up to `most` earlier or later: a logger of 50 Hz whose rows are not even.
io::Recording of_an_uneven_logger(const std::string& reference, int most, const std::string& id = "",
                                  const test::Parameters& p = {}) {
  auto config = test::baseline(reference, 60.0);
  config.rate_hz = 1000.0;
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  const io::Recording fast = test::record(config, id, p, 41);
  io::Recording out = fast;
  const auto take = [&](auto& column) {
    std::mt19937 random(7);
    std::uniform_int_distribution<int> late(-most, most);
    std::size_t rows = 0;
    for (std::size_t i = 10; i + 10 < column.size(); i += 20)
      column[rows++] = column[static_cast<std::size_t>(static_cast<int>(i) + late(random))];
    if (!column.empty()) column.resize(rows);
  };
  take(out.t_ns), take(out.acc_mps2), take(out.gyr_radps), take(out.mag_uT), take(out.temp_degC), take(out.current_A);
  take(out.supply_V), take(out.ref_q_world_body), take(out.ref_position_m), take(out.ref_moving);
  return out;
}

TEST(UnevenLogger, IsDiagnosedAsIfItsRowsWereEven) {
  const auto config = test::baseline("exact", 60.0);
  for (const int most : {1, 4}) {
    const Answer clean = diagnose(of_an_uneven_logger("exact", most), config);
    EXPECT_THAT(test::names(clean), IsEmpty()) << most;
    EXPECT_EQ(clean.diagnosis.verdict, Verdict::kNoMismatch) << clean.diagnosis.summary;
    EXPECT_THAT(
        test::names(diagnose(
            of_an_uneven_logger("exact", most, "gyr_temp_lin", {{"k_radps_per_K", {6e-4, -3e-4, 2e-4}}}), config)),
        ElementsAre("gyr_temp_lin"))
        << most;
    EXPECT_THAT(
        test::names(diagnose(of_an_uneven_logger("exact", most, "acc_lever", {{"r_m", {0.03, -0.02, 0.01}}}), config)),
        ElementsAre("acc_lever"))
        << most;
  }
}

TEST(UnevenLogger, StampsOfFewDecimalsMakeTheReferenceANoisyOne) {
  io::Recording r = of_an_uneven_logger("exact", 4, "gyr_temp_lin", {{"k_radps_per_K", {6e-4, -3e-4, 2e-4}}});
  std::mt19937 random(9);
  std::uniform_int_distribution<int> rounding(-5'000, 5'000);
  for (auto& t : r.t_ns) t += rounding(random);
  EXPECT_THAT(test::names(diagnose(r, test::baseline("exact", 60.0))), ElementsAre("gyr_temp_lin"));
}

}  // namespace
}  // namespace stillpoint::diag

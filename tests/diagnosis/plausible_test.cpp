/// Numbers that no part has are no answer.
#include "diagnosis/reference/plausible.h"

#include <gmock/gmock.h>

#include <utility>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

TEST(Plausible, NumbersDoNotUndoOneAnother) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  SensorSearch search = start_search(*s, kMag);
  const Series3& field = s->vector[kMag];
  const Series3 small = 0.02 * s->vector[kAcc];
  search.target.residual += small;
  Found law;
  law.id = "mag_soft_step";
  law.names = {"M_xx", "M_xy"};
  law.columns = {{-1, field.cwiseProduct(field)}, {-1, field.cwiseProduct(field) + 1e-2 * small}};
  EXPECT_FALSE(possible(*s, search, law)) << "-100 and 100 for what one of 1 does";
  law.names = {"M_xx"};
  law.columns = {{-1, small}};
  EXPECT_TRUE(possible(*s, search, law));
}

TEST(Plausible, GravityIsOffByWhatPlacesDifferAndByMoreThanTheScaleOfATranslation) {
  const auto config = test::baseline("exact", 60.0);
  Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  Found law;
  law.id = "acc_gravity";
  law.names = {"dg"};
  law.columns = {{-1, s->world_axis[2]}};
  const auto allowed = [&](double dg_mps2) {
    SensorSearch search = start_search(*s, kAcc);
    search.target.residual += dg_mps2 * s->world_axis[2];
    return possible(*s, search, law);
  };
  for (const auto& [dg_mps2, is_possible] : {std::pair{0.03, true}, {-0.03, true}, {0.003, false}, {-4.5, false}})
    EXPECT_EQ(allowed(dg_mps2), is_possible) << dg_mps2;
  EXPECT_TRUE(allowed(0.012));
  s->exact_reference = false;
  EXPECT_FALSE(allowed(0.012)) << "lines between a camera's frames take as much off a stroke";
  EXPECT_TRUE(allowed(0.03));
}

/// A camera that is late by 50 us is a clock that is off by 0.7 ppm just as well, and no clock is so good.
TEST(Plausible, AClockThatIsHardlyOffHasToExplainMore) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  Found law;
  law.id = "sys_skew";
  for (const auto& [rate, decades] : {std::pair{5e-7, 1.0}, {-5e-8, 2.0}, {3e-5, 0.0}}) {
    law.timing = Eigen::VectorXd::Constant(1, rate);
    EXPECT_NEAR(decades_below_usual(start_search(*s, kGyr), law), decades, 1e-9) << rate;
  }
}

/// Noise of a good gyroscope is a 250th of what 4 ms of a low-pass do: the simulator's and the model's filters are not
/// the same to that.
TEST(Plausible, NothingIsNamedThatIsOfTheFormOfAResponse) {
  auto config = test::baseline("exact", 100.0);
  config.gyroscope->noise_sd = 1.7e-4;
  config.environment.temperature = {.kind = "warm_up", .rise_K = 15.0};
  config.environment.current = {.kind = "steps"};
  const Answer answer = diagnose(test::record(config, "gyr_lpf", {{"tau_s", {0.004}}}, 11), config);
  EXPECT_THAT(test::names(answer), testing::ElementsAre("gyr_lpf")) << answer.diagnosis.summary;
}

/// A rail takes off what lies beyond it, all of it and no more: half as much again is something else.
TEST(Plausible, ARailTakesOffTheWholeOfWhatIsBeyond) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  Found law;
  law.id = "acc_sat";
  law.names = kWholeOrNothing;
  law.columns = {{-1, s->vector[kAcc].cwiseMin(11.0).cwiseMax(-11.0) - s->vector[kAcc]}};
  for (const auto& [share, is_possible] : {std::pair{0.1, false}, {0.5, true}, {1.0, true}, {1.4, false}}) {
    SensorSearch search = start_search(*s, kAcc);
    search.target.residual += share * law.columns.front().x;
    EXPECT_EQ(possible(*s, search, law), is_possible) << share;
  }
}

/// Beside a world that leans by 0.02 m/s^2 the field's reading, taken 0.24 times, takes back ten times as much.
TEST(Plausible, ALawDoesNotMakeWhatWasFoundSwell) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  SensorSearch search = start_search(*s, kAcc);
  Found leans;
  leans.id = "vertical_world";
  leans.kind = Kind::kConfiguration;
  leans.names = {"east"};
  leans.columns = {{-1, s->world_axis[0]}};
  const Series3 product = 0.1 * s->vector[kGyr].cwiseProduct(s->vector[kGyr]);
  search.target.residual += 0.02 * leans.columns[0].x + product;
  search.found = {leans};
  const Fit before = fit_profile(search.target, search.explained());
  Found law;
  law.names = {"k"};
  const auto moves = [&](const Series3& column) {
    law.columns = {{-1, column}};
    return moves_the_others(search, before, fit_profile(search.target, joined(search.explained(), law.columns)));
  };
  EXPECT_TRUE(moves(product + 0.2 * leans.columns[0].x));
  EXPECT_FALSE(moves(product));
}

}  // namespace
}  // namespace stillpoint::diag

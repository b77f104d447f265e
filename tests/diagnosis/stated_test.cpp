/// What fits is stated only where its numbers are known beside all else that was found, and where the body does not do
/// it.
#include <gmock/gmock.h>

#include <numbers>

#include "diagnosis/discovery/discover.h"
#include "diagnosis/reference/findings.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

/// A law of the catalogue along `column`, which was accepted with a reading that holds `size` of it.
Answer stated(const Signals& s, const Series3& column, double size, double gain_nats = 170.0) {
  EngineResult engine;
  engine.sensor[kAcc] = start_search(s, kAcc);
  SensorSearch& search = *engine.sensor[kAcc];
  search.target.residual += size * column;
  Found law;
  law.id = "acc_temp_lag";
  law.names = {"k"};
  law.units = {"m/s^2/K"};
  law.columns = {{-1, column}};
  law.gain_nats = gain_nats;
  search.found = {law};
  Answer answer;
  report_sensor(s, engine, kAcc, {}, answer);
  return answer;
}

TEST(Stated, ALawOfWhichNoNumberIsKnownFromZeroIsNot) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  const Series3 column = s->vector[kAcc].cwiseProduct(s->vector[kGyr]);
  EXPECT_THAT(test::names(stated(*s, column, 0.05)), testing::ElementsAre("acc_temp_lag"));
  const Answer nothing = stated(*s, column, 0.0);
  EXPECT_THAT(test::names(nothing), testing::IsEmpty());
  EXPECT_THAT(nothing.diagnosis.notices, testing::Contains(testing::HasSubstr("known from zero")));
}

TEST(Stated, WhatOneOfSoManyHypothesesGainsByChanceIsNot) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  const Series3 column = s->vector[kAcc].cwiseProduct(s->vector[kGyr]);
  EXPECT_THAT(test::names(stated(*s, column, 0.05, 20.0)), testing::ElementsAre("acc_temp_lag"));
  const Answer by_chance = stated(*s, column, 0.05, 8.0);
  EXPECT_THAT(test::names(by_chance), testing::Not(testing::Contains("acc_temp_lag")));
  EXPECT_THAT(by_chance.diagnosis.notices, testing::Contains(testing::HasSubstr("by chance")));
}

/// A line that follows a current is a law of it, if the line is the sensor's.
TEST(Stated, AVibrationOfTheBodyIsNoLawOfItsFrequency) {
  auto config = test::baseline("mocap", 60.0);
  config.environment.current.kind = "steps";
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  constexpr double kLine_Hz = 21.3;
  const Series swing = (2.0 * std::numbers::pi * kLine_Hz * s->t_s.array()).sin();
  const auto laws_of = [&](const char* line) {
    EngineResult engine;
    engine.sensor[kGyr] = start_search(*s, kGyr);
    engine.sensor[kGyr]->target.residual.col(1) += 0.05 * swing.cwiseProduct(s->current_A);
    Found f;
    f.id = line;
    f.kind = f.id == kBodyVibration ? Kind::kConfiguration : Kind::kNamed;
    f.shape = kLine_Hz, f.shape_unit = "Hz";
    f.names = {"b"};
    f.columns = {{1, swing}};
    engine.sensor[kGyr]->found = {f};
    discover(*s, engine);
    return std::ranges::count_if(engine.sensor[kGyr]->found, [](const Found& law) { return is_unknown(law.id); });
  };
  EXPECT_GT(laws_of("gyr_alias"), 0);
  EXPECT_EQ(laws_of(kBodyVibration), 0);
}

}  // namespace
}  // namespace stillpoint::diag

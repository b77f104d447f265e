/// What fits is stated only where its numbers are known beside all else that was found, and where the body does not do
/// it.
#include <gmock/gmock.h>

#include <numbers>

#include "diagnosis/discovery/discover.h"
#include "diagnosis/reference/findings.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

/// A law of the catalogue along `column`.
Found along(const char* id, const Series3& column, double gain_nats) {
  Found law;
  law.id = id;
  law.names = {"k"};
  law.units = {"m/s^2/K"};
  law.columns = {{-1, column}};
  law.gain_nats = gain_nats;
  return law;
}

/// What is said of laws, the first of which was accepted with a reading that holds `size` of its column.
Answer stated(const Signals& s, std::vector<Found> found, double size) {
  EngineResult engine;
  engine.sensor[kAcc] = start_search(s, kAcc);
  SensorSearch& search = *engine.sensor[kAcc];
  search.target.residual += size * found.front().columns.front().x;
  search.found = std::move(found);
  Answer answer;
  report_sensor(s, engine, kAcc, {}, answer);
  return answer;
}

Answer stated(const Signals& s, const Series3& column, double size, double gain_nats = 170.0) {
  return stated(s, {along("acc_temp_lag", column, gain_nats)}, size);
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

/// What was found beside it shares its columns and is not stated.
TEST(Stated, NoNumberIsFittedBesideALawThatIsNot) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  const Series3 column = s->vector[kAcc].cwiseProduct(s->vector[kGyr]);
  const Found law = along("acc_temp_lag", column, 170.0);
  const Found shares = along("acc_volt", column + 0.1 * column.cwiseAbs2(), 8.0);
  const Answer alone = stated(*s, std::vector{law}, 0.05), beside = stated(*s, std::vector{law, shares}, 0.05);
  ASSERT_THAT(beside.diagnosis.notices, testing::Contains(testing::HasSubstr("acc_volt fits, but is not stated")));
  ASSERT_THAT(test::names(beside), testing::ElementsAre("acc_temp_lag"));
  const Parameter &here = beside.diagnosis.findings[0].parameters[0],
                  &there = alone.diagnosis.findings[0].parameters[0];
  EXPECT_NEAR(here.value, there.value, 1e-3 * std::abs(there.value));
  EXPECT_NEAR(here.ci95[1] - here.ci95[0], there.ci95[1] - there.ci95[0], 1e-3 * (there.ci95[1] - there.ci95[0]));
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

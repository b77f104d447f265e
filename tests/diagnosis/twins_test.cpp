// Null twins: noise drawn with the colour of the recording's own, and the search gated by what it makes of it.
#include "diagnosis/reference/twins.h"

#include <gmock/gmock.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

Signals signals_of(const io::Recording& recording, const sim::SimulationConfig& config) {
  return *make_signals(recording, config, {});
}

TEST(Twins, NoiseIsWhiteAgainOnceItIsWhitened) {
  auto config = test::baseline("mocap", 40.0);
  config.gyroscope->noise_band_hz = 8.0;
  const Signals s = signals_of(test::record(config, "", {}, 31), config);
  const Target target = make_target(s, kGyr);
  const NoiseModel noise(target.layout, target.residual);
  const Series white = Series::Random(s.n);
  const Series back = noise.whiten(target.layout, noise.coloured(target.layout, white, 1), 1);
  const Series counted = white.array() * target.layout.counts;
  EXPECT_LT((back - counted).cwiseAbs().maxCoeff(), 1e-6);  // rounding only: the inverse filter is stable
}

TEST(Twins, ScoreNothingWhereTheFindingScoresHighAndKeepIt) {
  const auto config = test::baseline("exact", 40.0);
  Signals s = signals_of(test::record(config, "gyr_asym", {{"k", {2e-3, -2e-3, 2e-3}}}, 32), config);
  EngineResult result = search_all(s);
  ASSERT_EQ(result.sensor[kGyr]->found.size(), 1u);
  const double net = result.sensor[kGyr]->found[0].net_nats;
  const std::vector<double> scores = null_twins(s, *result.sensor[kGyr], 4, 1);
  ASSERT_EQ(scores.size(), 4u);
  for (const double score : scores) EXPECT_LT(score, 0.2 * net);  // the effect itself is not in them
  const auto said = gate_by_twins(s, result, 4);
  EXPECT_THAT(said, testing::ElementsAre(testing::HasSubstr("null twins of gyr")));
  EXPECT_EQ(result.sensor[kGyr]->found.size(), 1u);
}

TEST(Twins, DropAFindingThatNothingScoresAsHighAs) {
  const auto config = test::baseline("exact", 40.0);
  const io::Recording recording = test::record(config, "gyr_asym", {{"k", {2e-3, -2e-3, 2e-3}}}, 32);
  Signals s = signals_of(recording, config);
  EngineResult result = search_all(s);
  ASSERT_EQ(result.sensor[kGyr]->found.size(), 1u);
  result.sensor[kGyr]->found[0].net_nats = -1.0;  // as if it had scored less than noise does
  const auto said = gate_by_twins(s, result, 2);
  EXPECT_THAT(said, testing::Contains(testing::HasSubstr("gyr_asym is not stated")));
  EXPECT_TRUE(result.sensor[kGyr]->found.empty());
}

}  // namespace
}  // namespace stillpoint::diag

// A law is stated by its name only while nothing freer on the same driver explains more: laws taken out of the library,
// and laws that no library has.
#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/reference/adequacy.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using test::baseline;
using test::names;
using test::record;

sim::SimulationConfig warm(const std::string& reference) {
  auto config = baseline(reference, 60.0);
  config.environment.temperature = {.kind = "warm_up", .rise_K = 10.0, .tau_s = 40.0};
  config.environment.current.kind = "steps";
  return config;
}

struct Deleted {
  const char *id, *key;
  std::vector<double> values;
};
void PrintTo(const Deleted& law, std::ostream* out) { *out << law.id; }
class LawDeleted : public testing::TestWithParam<Deleted> {};
INSTANTIATE_TEST_SUITE_P(Adequacy, LawDeleted,
                         testing::Values(Deleted{"gyr_temp_lin", "k_radps_per_K", {3e-4, -2e-4, 1e-4}},
                                         Deleted{"acc_lever", "r_m", {0.02, -0.015, 0.01}},
                                         Deleted{"acc_cubic", "k3_per_mps2_2", {2e-5, -2e-5, 1e-5}},
                                         Deleted{"gyr_temp_quad", "k2_radps_per_K2", {5e-5, 1e-5, 9e-5}},
                                         Deleted{"mag_field_step", "b_world_uT", {1.0, -0.7, 0.5}},
                                         Deleted{"mag_gradient", "G_uT_per_m", {3, 1, 0.1, 1, 2, -0.4, 0.1, -0.4, -5}},
                                         Deleted{"mag_current", "k_uT_per_A", {0.5, -0.4, 0.3}}));

TEST_P(LawDeleted, IsAnsweredAsUnknownAndNotByItsNeighbour) {
  const Deleted& law = GetParam();
  const auto config = warm("exact");
  test::Parameters parameters{{law.key, law.values}};
  if (std::string(law.id) == "mag_field_step") parameters["t0_s"] = {25.0};
  const auto recording = record(config, law.id, parameters, 21);
  EXPECT_THAT(names(diagnose(recording, config)), testing::ElementsAre(law.id));
  const auto without = names(diagnose(recording, config, {law.id}));
  ASSERT_FALSE(without.empty());
  EXPECT_THAT(without, testing::Each(testing::StartsWith("unknown:")));
}

/// Over a warm-up of a minute the lag behind the temperature is its square but for a few nats.
TEST(Adequacy, ALagThatIsNotInTheLibraryIsNotCalledASquare) {
  auto config = baseline("exact", 60.0);
  config.environment.temperature = {.kind = "warm_up", .start_degC = 21.0, .rise_K = 8.0, .tau_s = 50.0};
  for (const std::uint64_t seed : {31, 32, 34, 35}) {
    const auto recording =
        record(config, "gyr_temp_lag", {{"k_radps_per_K", {4e-4, -2e-4, 1e-4}}, {"tau_s", {12.0}}}, seed);
    EXPECT_THAT(names(diagnose(recording, config)), testing::ElementsAre("gyr_temp_lag")) << seed;
    // A course over time that nothing recorded drives need not hold on motion left out of the fit: then nothing is
    // named.
    const auto without = diagnose(recording, config, {"gyr_temp_lag"});
    EXPECT_THAT(names(without), testing::Each(testing::StartsWith("unknown:"))) << seed;
    EXPECT_LE(names(without).size(), 1U) << seed;
  }
}

class LawAdequate : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Adequacy, LawAdequate, testing::Values("exact", "mocap"));

TEST_P(LawAdequate, ALawThatBendsWhereTheCatalogueIsStraightIsFoundAsAFormulaOfItsDriver) {
  const auto config = warm(GetParam());
  auto recording = record(config, "", {}, 22);
  for (std::size_t i = 0; i < recording.size(); ++i)
    recording.mag_uT[i] += std::sqrt(std::abs(recording.current_A[i])) * Vec3(1.0, -0.7, 0.4);
  const Answer answer = diagnose(recording, config);
  ASSERT_FALSE(answer.diagnosis.findings.empty());
  EXPECT_EQ(answer.diagnosis.findings[0].effect, "unknown:abs(I)^0.5");
}

TEST_P(LawAdequate, TwoLawsOfOneDriverKeepTheirNames) {
  auto config = warm(GetParam());
  config.effects.push_back({.id = "acc_asym", .parameters = {{"k", {4e-3, -4e-3, 4e-3}}}, .axes = {}, .window_s = {}});
  const auto recording = record(config, "acc_cubic", {{"k3_per_mps2_2", {5e-5, -5e-5, 5e-5}}}, 23);
  config.effects.clear();
  EXPECT_THAT(names(diagnose(recording, config)), testing::UnorderedElementsAre("acc_asym", "acc_cubic"));
}

TEST(Adequacy, AShiftAfterWhichMoreIsLeftIsNoLaw) {
  Result<Signals> s = make_signals(record(baseline("mocap", 60.0), "", {}, 5), baseline("mocap", 60.0), {});
  ASSERT_TRUE(s);
  const SensorSearch search = start_search(*s, kGyr);
  const Series3 noise = fit_profile(search.target, {}).leftover;
  Found shift;
  shift.offset = 0.2 * noise;
  EXPECT_TRUE(leaves_less(search, shift));
  shift.offset = -0.2 * noise;
  EXPECT_FALSE(leaves_less(search, shift));
}

/// On a turntable the vertical wobbles by a thousandth; bias and matrix take the rest of a law of it.
TEST(Adequacy, ADriverThatHardlyVariedIsNoneOfALaw) {
  Result<Signals> s = make_signals(record(baseline("mocap", 60.0), "", {}, 5), baseline("mocap", 60.0), {});
  ASSERT_TRUE(s);
  SensorSearch search = start_search(*s, kMag);
  Found law;
  law.id = "unknown:up";
  for (const double wobble : {1e-3, 0.3}) {
    law.columns.clear();
    search.target.residual.setZero();
    for (int axis = 0; axis < 3; ++axis) {
      const Series up = Series::Ones(s->n) + wobble * (0.7 * s->t_s.array()).sin().matrix();
      law.columns.push_back({axis, up});
      search.target.residual.col(axis) = 50.0 * up;
    }
    EXPECT_EQ(varies(search, law, fit_beside(search, law)), wobble > 0.1) << wobble;
  }
}

Found weighed(const char* id, double nats, Kind kind, Window window = {}) {
  Found f;
  f.id = id;
  f.kind = kind;
  f.window = window;
  f.gain_nats = f.net_nats = nats;
  return f;
}

TEST(Adequacy, AFactorThatWasNotSeenToMatterIsNotNamed) {
  EXPECT_TRUE(is_part_of("unknown:(V-V0)", "unknown:f_x*(V-V0)"));
  EXPECT_TRUE(is_part_of("unknown:(T-T0)", "unknown:(T-T0)*(T-T0)"));
  EXPECT_FALSE(is_part_of("unknown:f_x*(V-V0)", "unknown:f_x*(V-V0)"));
  EXPECT_FALSE(is_part_of("unknown:f", "unknown:f_x*(V-V0)"));
  EXPECT_FALSE(is_part_of("acc_volt", "unknown:f_x*(V-V0)"));
  const auto found = [](const char* id, double nats) { return weighed(id, nats, Kind::kUnknown); };
  EXPECT_EQ(best_explanation({found("unknown:f_x*(V-V0)", 900), found("unknown:(V-V0)", 898)}, true)->id,
            "unknown:(V-V0)");
  EXPECT_EQ(best_explanation({found("unknown:f_x*(V-V0)", 900), found("unknown:(V-V0)", 800)}, true)->id,
            "unknown:f_x*(V-V0)");
}

/// About a body that lies still any law of its orientation is a constant while it acts.
TEST(Adequacy, WhatEndsWhereAStepMayBeginIsTheStep) {
  const auto found = [](const char* id, double nats, Window window) { return weighed(id, nats, Kind::kNamed, window); };
  const Window before{true, 0, 300}, after{true, 300, 1000};
  EXPECT_EQ(best_explanation({found("mag_sat", 900, before), found("mag_hard_step", 899, after)}, true)->id,
            "mag_hard_step");
  EXPECT_EQ(best_explanation({found("mag_field_step", 900, after), found("mag_hard_step", 899, after)}, true)->id,
            "mag_field_step");
  EXPECT_EQ(best_explanation({found("mag_sat", 900, before), found("mag_hard_step", 800, after)}, true)->id, "mag_sat");
}

/// What is believed sooner is tried first: a world that leans before a product, and a delay, which may be the clock of
/// all, before a filter that is none better.
TEST(Adequacy, WhatIsBelievedSoonerIsTriedFirst) {
  const auto best = [&](double leans, double filter) {
    return std::pair{
        best_explanation(
            {weighed("unknown:m*|w|", 370, Kind::kUnknown), weighed("vertical_world", leans, Kind::kConfiguration)},
            true)
            ->id,
        best_explanation({weighed("acc_lpf", filter, Kind::kTiming), weighed("acc_delay", 900, Kind::kTiming)}, true)
            ->id};
  };
  EXPECT_EQ(best(200, 902), std::pair(std::string("vertical_world"), std::string("acc_delay")));
  EXPECT_EQ(best(100, 950), std::pair(std::string("unknown:m*|w|"), std::string("acc_lpf")));
}

}  // namespace
}  // namespace stillpoint::diag

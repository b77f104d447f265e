/// The referee must be right before the player is judged.
#include "diagnosis/prove/prove.h"

#include <gmock/gmock.h>

#include "diagnosis/prove/sha256.h"

namespace stillpoint::diag {
namespace {

using nlohmann::json;

TEST(Sha256, GivesTheDigestsOfTheStandard) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

CaseTruth truth(std::string kind, std::vector<std::string> effects) {
  CaseTruth t{
      .kind = std::move(kind), .reference = "exact", .noise = "white", .effects = {}, .window_s = {}, .d_prime = 20};
  for (auto& e : effects) t.effects[e] = {{"k", {1.0, 2.0, 3.0}}};
  return t;
}
json answer(std::vector<std::string> effects) {
  json a{{"verdict", "explained"}, {"findings", json::array()}};
  for (auto& e : effects) a["findings"].push_back({{"effect", e}, {"equivalent", json::array()}});
  return a;
}
std::string outcome(const CaseTruth& t, const json& a) { return score_case("1", t, a).outcome; }

TEST(Prove, ScoresOutcomesAsTheOutsideRefereeDoes) {
  EXPECT_EQ(outcome(truth("single", {"gyr_gsens"}), answer({"gyr_gsens"})), "right");
  EXPECT_EQ(outcome(truth("single", {"gyr_temp_lin"}), answer({"gyr_temp_quad"})), "family");
  EXPECT_EQ(outcome(truth("single", {"gyr_temp_lin"}), answer({"acc_temp_lin"})), "wrong");
  EXPECT_EQ(outcome(truth("single", {"mag_delay"}), answer({"sys_offset"})), "family");
  EXPECT_EQ(outcome(truth("novel", {"novel_gyr_Tf"}), answer({"unknown:f*T"})), "unknown");
  EXPECT_EQ(outcome(truth("clean", {}), answer({})), "missed");
  EXPECT_EQ(outcome(truth("single", {"acc_quad"}), json()), "failed");
  EXPECT_EQ(outcome(truth("notemp", {"gyr_temp_lin"}), answer({"gyr_drift"})), "unknown");
  EXPECT_EQ(outcome(truth("single", {"acc_quad"}), answer({"gyr_drift"})), "wrong");
  auto equivalent = answer({"gyr_delay"});
  equivalent["findings"][0]["equivalent"] = {"gyr_lpf"};
  EXPECT_EQ(outcome(truth("single", {"gyr_lpf"}), equivalent), "right");
}

TEST(Prove, CountsEveryUntrueNameAndBothOfAPair) {
  const auto s =
      score_case("1", truth("pair", {"acc_quad", "gyr_gsens"}), answer({"acc_quad", "mag_delay", "gyr_gsens"}));
  EXPECT_EQ(s.untrue, 1);
  EXPECT_TRUE(s.both);
}

TEST(Prove, ChecksTrueNumbersAgainstTheirIntervals) {
  auto a = answer({"acc_quad"});
  a["findings"][0]["parameters"] = {{{"name", "k_x"}, {"value", 1.1}, {"ci95", {0.9, 1.3}}, {"unit", "1"}},
                                    {{"name", "k_y"}, {"value", 5.0}, {"ci95", {4.0, 6.0}}, {"unit", "1"}}};
  const auto s = score_case("1", truth("single", {"acc_quad"}), a);
  EXPECT_EQ(s.coverage.at("acc_quad").stated, 2U);
  EXPECT_EQ(s.coverage.at("acc_quad").inside, 1U);
  EXPECT_THAT(tables({s}), testing::ContainsRegex("by effect\n  acc_quad +1 of +2"));
}

TEST(Prove, SealsChangeWithTruthAndNonce) {
  const auto t = truth("single", {"acc_quad"});
  EXPECT_NE(seal("1", t, "a"), seal("1", t, "b"));
  EXPECT_NE(seal("1", t, "a"), seal("1", truth("single", {"acc_asym"}), "a"));
}

TEST(Prove, DrawsTheSameCaseFromTheSameSaltAndHidesWhatIsToBeHidden) {
  const auto a = draw_case("s", 11, true), b = draw_case("s", 11, true), c = draw_case("t", 11, true);
  EXPECT_EQ(a.truth.kind, "notemp");
  EXPECT_TRUE(a.recording.temp_degC.empty());
  EXPECT_TRUE(a.baseline.effects.empty());
  EXPECT_EQ(a.recording.gyr_radps, b.recording.gyr_radps);
  EXPECT_NE(a.recording.gyr_radps, c.recording.gyr_radps);
  EXPECT_NE(a.nonce, b.nonce);
}

TEST(Prove, TakesTheTrueLawOutOfTheSolversLibraryAndSealsWhatItWas) {
  const SealedCase c = draw_case("salt", 9, true);
  ASSERT_EQ(c.truth.kind, "deleted");
  ASSERT_EQ(c.without.size(), 1U);
  EXPECT_TRUE(c.truth.effects.contains(c.without.front()));
  EXPECT_TRUE(c.baseline.effects.empty());
  EXPECT_TRUE(draw_case("salt", 5, true).without.empty());
}

TEST(Prove, LetsAnEstimatorAbsorbThePhysics) {
  const SealedCase c = draw_case("salt", 14, true);
  ASSERT_EQ(c.truth.kind, "absorb");
  EXPECT_TRUE(c.truth.effects.contains("sys_tracker"));
  EXPECT_EQ(c.truth.effects.size(), 2U);
}

TEST(Prove, MeasuresTheLimitInUnitsOfTheLikelihoodRatioTest) {
  // One coefficient is found by the test that knows its law in half of the cases at d' = 2.576 (99 % point of the
  // normal).
  std::vector<CaseScore> scores;
  for (int i = 0; i < 60; ++i) {
    CaseScore s;
    s.truth.kind = "limit", s.truth.reference = "exact";
    s.truth.effects["mag_current"]["k"] = {1.0};
    s.truth.d_prime = 2.0 + 0.1 * i;
    s.outcome = s.truth.d_prime > 2.576 * 1.5 ? "right" : "missed";
    if (s.outcome == "right") s.said = {"mag_current"};
    scores.push_back(s);
  }
  const std::string text = limit_tables(scores);
  const std::size_t at = text.find("): found ");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_NEAR(std::stod(text.substr(at + 9)), 1.5, 0.05) << text;
}

TEST(Prove, RefusesWhatIsNoTruth) {
  for (const char* text : {"", "[]", "{}", "{\"kind\": 3, \"effects\": {}}", "{\"kind\": \"single\"}"})
    EXPECT_FALSE(parse_truth(text, "x.json").has_value()) << text;
  const auto t = parse_truth(
      R"({"kind": "single", "reference": "exact", "effects": {"gyr_gsens": {"G": [[1, 2], [3, 4]]}}, "window": [1, 2]})",
      "x");
  ASSERT_TRUE(t.has_value());
  EXPECT_EQ(t->effects.at("gyr_gsens").at("G"), (std::vector<double>{1, 2, 3, 4}));
  EXPECT_TRUE(t->window_s.has_value());
}

TEST(Prove, AnEffectOnOneAxisIsZeroOnTheOthers) {
  const auto t = parse_truth(
      R"({"kind": "oneaxis", "reference": "exact", "effects": {"gyr_asym": {"k": [1, 2, 3]}}, "axes": {"gyr_asym": 2}})",
      "x");
  ASSERT_TRUE(t.has_value());
  EXPECT_EQ(t->effects.at("gyr_asym").at("k"), (std::vector<double>{0, 0, 3}));
}

TEST(Prove, WilsonIntervalsAreThoseOfTheTables) {
  const auto none = wilson95(0, 72);
  EXPECT_EQ(none[0], 0.0);
  EXPECT_NEAR(none[1], 0.0507, 1e-4);
  EXPECT_NEAR(wilson95(9, 10)[0], 0.5958, 1e-4);
}

}  // namespace
}  // namespace stillpoint::diag

/// Slow rows: what is slow stands out of a camera's errors there, and what is none stays so.
#include "diagnosis/reference/slow_look.h"

#include <gmock/gmock.h>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

/// A hand beside a camera, sampled often enough that its errors are metres per second squared from row to row.
sim::SimulationConfig beside_a_camera(const std::string& effects) {
  return test::parsed(
      "rate_hz: 200\naccelerometer: {noise_mps2: 0.01}\ngyroscope: {noise_radps: 0.001}\n"
      "magnetometer: {noise_uT: 0.3}\nmotion: {kind: hand, duration_s: 60}\n"
      "reference: {kind: mocap, orientation_sd_rad: 0.0006, position_sd_m: 0.0003}\n"
      "environment: {current: {kind: steps}}\neffects: " +
      effects + "\n");
}

Answer answer_to(const std::string& effects, std::uint64_t seed) {
  return diagnose(io::to_recording(sim::simulate(beside_a_camera(effects), seed)), beside_a_camera("[]"));
}

Signals signals_of(const io::Recording& recording) {
  return *make_signals(recording, beside_a_camera("[]"),
                       {Mask(recording.size()), Mask(recording.size()), Mask(recording.size())});
}

/// rms of the residual's means over three seconds.
double slow_rms(const Signals& s, Sensor k) { return means_of_rows(s.residual[k], std::lround(3.0 / s.dt_s)).norm(); }

TEST(SlowLook, ACurrentInTheAccelerometerIsNotLostInACamerasErrors) {
  for (const std::uint64_t seed : {1, 2}) {
    const Answer answer = answer_to("[{effect: law, sensor: acc, law: \"I\", k: [0.02, 0, -0.01]}]", seed);
    const Finding* f = test::finding(answer, "unknown:I");
    ASSERT_NE(f, nullptr) << answer.diagnosis.summary;
    const Parameter& x = test::parameter(*f, "k_x");
    EXPECT_LT(x.ci95[0], 0.02);
    EXPECT_GT(x.ci95[1], 0.02);
    EXPECT_LT(x.ci95[1] - x.ci95[0], 0.01);
    EXPECT_THAT(answer.diagnosis.notices, testing::Contains(testing::HasSubstr("acc: looked at in means")));
  }
}

TEST(SlowLook, NothingIsFoundWhereNothingWasLeftOut) {
  for (const std::uint64_t seed : {4, 5})
    EXPECT_THAT(test::names(answer_to("[]", seed)), testing::IsEmpty()) << "seed " << seed;
}

TEST(SlowLook, TheEdgesOfRestsSumToWhatMoves) {
  const Signals s = signals_of(io::to_recording(sim::simulate(beside_a_camera("[]"), 7)));
  Signals cut = s;
  cut.edges_of_rests = {};
  EXPECT_LT(slow_rms(*slow_rows(s), kAcc), 0.7 * slow_rms(*slow_rows(cut), kAcc));
}

TEST(SlowLook, ALawOfTheMeansIsTheMeanOfTheLaw) {
  const Signals s = signals_of(io::to_recording(sim::simulate(beside_a_camera("[]"), 8)));
  Signals shifted = s;
  shifted.residual[kGyr].col(1) += s.current_A;
  const Signals slow = *slow_rows(s), with = *slow_rows(shifted);
  const Series3 law = with.residual[kGyr] - slow.residual[kGyr];
  const Eigen::Index edge = 10, inner = slow.n - 2 * edge;  // the ends are muted
  EXPECT_GT(law.col(1).segment(edge, inner).norm(), 1.0);
  EXPECT_LT((law.col(1) - slow.current_A).segment(edge, inner).norm(), 1e-9);
}

TEST(SlowLook, WhatMovesWithTheBodyIsLeftToAllRows) {
  Signals s = signals_of(io::to_recording(sim::simulate(beside_a_camera("[]"), 11)));
  s.residual[kGyr] += Series3(1e-3 * s.rate.cwiseAbs2());
  Signals slow = *slow_rows(s);
  EngineResult found = search_all(slow);
  ASSERT_FALSE(found.sensor[kGyr]->found.empty());
  keep_what_is_slow(found);
  EXPECT_TRUE(found.sensor[kGyr]->found.empty());
}

TEST(SlowLook, IsHeardWhereItExplainsClearlyMore) {
  const auto with_gain = [](double gain_nats) {
    EngineResult r;
    r.sensor[kAcc].emplace();
    r.sensor[kAcc]->found.emplace_back();
    r.sensor[kAcc]->found.back().gain_nats = gain_nats;
    return r;
  };
  EXPECT_TRUE(is_seen_better(with_gain(140.0), with_gain(100.0), kAcc));
  EXPECT_FALSE(is_seen_better(with_gain(125.0), with_gain(100.0), kAcc));
  EXPECT_FALSE(is_seen_better(with_gain(140.0), with_gain(100.0), kGyr));
  EngineResult of_a_product = with_gain(140.0), plain = with_gain(100.0), of_another = with_gain(100.0);
  of_a_product.sensor[kAcc]->found[0].id = "unknown:d(T) * f_z";
  plain.sensor[kAcc]->found[0].id = "unknown:d(T)";
  of_another.sensor[kAcc]->found[0].id = "acc_volt";
  for (EngineResult* r : {&of_a_product, &plain}) r->sensor[kAcc]->found[0].kind = Kind::kUnknown;
  EXPECT_FALSE(is_seen_better(of_a_product, plain, kAcc)) << "the same cause: all rows tell its form";
  EXPECT_TRUE(is_seen_better(of_a_product, of_another, kAcc));
  EngineResult of_a_clock = with_gain(100.0);
  of_a_clock.system.push_back({.found = {}, .lead = kAcc, .sensors = {kAcc, kGyr}});
  EXPECT_FALSE(is_seen_better(with_gain(140.0), of_a_clock, kAcc));
}

TEST(SlowLook, AnExactReferenceNeedsNone) {
  sim::SimulationConfig exact = beside_a_camera("[]");
  exact.reference = {};
  exact.reference.kind = "exact";
  EXPECT_FALSE(slow_rows(signals_of(io::to_recording(sim::simulate(exact, 9)))).has_value());
}

TEST(SlowLook, MissingRowsAreWeighedOut) {
  Signals s = signals_of(io::to_recording(sim::simulate(beside_a_camera("[]"), 10)));
  const Signals whole = *slow_rows(s);
  s.residual[kAcc].middleRows(1000, 60).setConstant(50.0);
  std::fill_n(s.muted[kAcc].begin() + 1000, 60, 1);
  const Signals gap = *slow_rows(s);
  EXPECT_GT(std::count(gap.muted[kAcc].begin(), gap.muted[kAcc].end(), 1), 2);
  for (Eigen::Index i = 0; i < gap.n; ++i) {
    const double usual = gap.muted[kAcc][static_cast<std::size_t>(i)] ? 1e9 : 3.0 + whole.residual[kAcc].row(i).norm();
    EXPECT_LT(gap.residual[kAcc].row(i).norm(), usual) << i;
  }
}

}  // namespace
}  // namespace stillpoint::diag

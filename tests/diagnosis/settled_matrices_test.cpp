/// Laws that are seen through a matrix of the simulation that is wrong, and laws that were found before the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/discovery/law_delta.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/engine.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/settled_matrices.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag::test {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

Mat3 bare(double size) {
  Mat3 m;
  m << 0.6, -0.9, 0.5, 1.0, -0.5, -0.8, -0.4, 0.9, 0.7;
  return Mat3::Identity() + size * m;
}

/// What parts that nobody has calibrated read, and the simulation of ideal ones.
io::Recording uncalibrated(const std::vector<sim::EffectConfig>& effects, std::uint64_t seed) {
  auto truth = baseline("exact", 60.0);
  truth.rate_hz = 100;
  truth.accelerometer->matrix = bare(0.03), truth.gyroscope->matrix = bare(-0.03),
  truth.magnetometer->matrix = bare(0.05);
  truth.effects = effects;
  return io::to_recording(sim::simulate(truth, seed));
}

sim::EffectConfig entry(const std::string& id, const Parameters& parameters) {
  return {.id = id, .parameters = parameters, .axes = {}, .window_s = {}};
}

Answer against_ideal(const io::Recording& recording) {
  auto ideal = baseline("exact", 60.0);
  ideal.rate_hz = 100;
  return diagnose(recording, ideal);
}

double number(const Finding& f, const std::string& name) {
  for (const Parameter& p : f.parameters)
    if (p.name == name) return p.value;
  ADD_FAILURE() << f.effect << " has no " << name;
  return 0.0;
}

TEST(SettledMatrices, ALatenessIsOneLawBehindWrongMatrices) {
  const Answer answer = against_ideal(uncalibrated({entry("sys_offset", {{"tau_s", {0.024}}})}, 1));
  ASSERT_THAT(names(answer), ElementsAre("sys_offset"));
  EXPECT_NEAR(number(answer.diagnosis.findings[0], "tau"), 0.024, 1e-4);
  ASSERT_TRUE(answer.numbers[kMag]);
  EXPECT_LT((answer.numbers[kMag]->matrix - bare(0.05)).norm(), 2e-3);
}

TEST(SettledMatrices, ALeverIsOneLawBehindWrongMatrices) {
  const Answer answer = against_ideal(uncalibrated({entry("acc_lever", {{"r_m", {0.3, -0.2, 0.25}}})}, 2));
  ASSERT_THAT(names(answer), ElementsAre("acc_lever"));
  EXPECT_NEAR(number(answer.diagnosis.findings[0], "r_x"), 0.3, 1e-3);
  EXPECT_NEAR(number(answer.diagnosis.findings[0], "r_y"), -0.2, 1e-3);
}

TEST(SettledMatrices, TheResidualTellsOfTheSimulationAsItWasGiven) {
  const io::Recording recording = uncalibrated({entry("sys_offset", {{"tau_s", {0.024}}})}, 3);
  auto ideal = baseline("exact", 60.0);
  ideal.rate_hz = 100;
  auto told = ideal;
  told.magnetometer->matrix = bare(0.05);
  const auto before = [&](const sim::SimulationConfig& c) {
    for (const ChannelResidual& r : diagnose(recording, c).diagnosis.residual)
      if (r.channel == "mag_x") return r.rms_before;
    return 0.0;
  };
  EXPECT_GT(before(ideal), 1.3 * before(told));
}

TEST(SettledMatrices, ALatenessBesideALeverIsOfAllSensors) {
  const Answer answer = against_ideal(
      uncalibrated({entry("sys_offset", {{"tau_s", {0.004}}}), entry("acc_lever", {{"r_m", {0.3, -0.2, 0.25}}})}, 4));
  EXPECT_THAT(names(answer), UnorderedElementsAre("sys_offset", "acc_lever"));
}

/// y = 0.95 (f + k play): a matrix that nothing shows of before the law is found is the law's own as well.
TEST(SettledMatrices, ALawOutsideTheCatalogueIsThatBeforeTheMatrix) {
  constexpr double kTrue = 0.05 / 0.95;
  const auto config = baseline("exact", 60.0);
  auto signals = make_signals(record(config, "", {}, 8), config, {});
  ASSERT_TRUE(signals);
  Signals& s = *signals;
  sim::EffectConfig law = entry("law:play(f, 1)", {{"k", {1, 1, 1}}});
  law.sensors = {sim::Sensor::kAcc};
  const Series3 play = *law_delta(s, kAcc, law), noise = s.residual[kAcc];
  s.reading[kAcc] = 0.95 * (s.predicted[kAcc] + kTrue * play) + noise;
  s.residual[kAcc] = s.reading[kAcc] - s.predicted[kAcc];
  EngineResult engine;
  engine.sensor[kAcc] = start_search(s, kAcc);
  Found found;
  found.id = "unknown:play(f, 1)", found.kind = Kind::kUnknown;
  for (int axis = 0; axis < 3; ++axis) found.columns.push_back({axis, play.col(axis)});
  engine.sensor[kAcc]->found = {found};
  const Eigen::VectorXd through = finish(*engine.sensor[kAcc]).values;
  EXPECT_NEAR(through[0], 0.95 * kTrue, 2e-3) << "seen through the matrix";
  settle_beside_laws(s, engine);
  const Eigen::VectorXd settled = finish(*engine.sensor[kAcc]).values;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(settled[axis] / through[axis], 1.0 / 0.95, 2e-3);
    EXPECT_NEAR(settled[axis], kTrue, 2e-3);
  }
  EXPECT_NEAR(s.triad[kAcc].matrix(0, 0), 1.0 / 0.95, 2e-3);
}

/// A line is found first, beside a step seven times as large, and its frequency may be five deviations off by that;
/// where it stayed so, products of it with the temperature made up for it.
TEST(ShapesAgain, ALineIsSharpenedWhenSomethingElseIsFound) {
  auto truth = with_law(
      "  - {effect: mag_line, b_uT: [3, -2.5, 2], f_hz: 10.886, phase_rad: 4.9}\n"
      "  - {effect: mag_hard_step, b_uT: [12, -15, 14], t0_s: 31}\n");
  auto given = truth;
  given.effects.clear();
  auto signals = make_signals(io::to_recording(sim::simulate(truth, 5)), given, {});
  ASSERT_TRUE(signals);
  SensorSearch search = *search_all(*signals).sensor[kMag];
  ASSERT_EQ(search.found.size(), 2U);
  const bool line_first = search.found[0].id == "mag_line";
  Found line = search.found[line_first ? 0 : 1], step = search.found[line_first ? 1 : 0];
  ASSERT_EQ(line.id, "mag_line");
  ASSERT_EQ(step.id, "mag_hard_step");
  line.shape += 3e-4;
  search.found = {line};
  accept(search, step);
  EXPECT_NEAR(search.found[0].shape, 10.886, 5e-5);
}

/// Along the axis of a turntable a lever does nothing: whatever number it had there, the improved simulation would
/// take it to other motions.
TEST(Untold, TheLeverAlongATurntablesAxisStaysSmall) {
  const Vec3 r(0.05, -0.03, 0.02);
  sim::SimulationConfig config;
  config.rate_hz = 100;
  config.accelerometer = sim::TriadConfig{.noise_sd = 0.005};
  config.gyroscope = sim::TriadConfig{.noise_sd = 5e-4};
  std::mt19937 engine(6);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sd) { return Vec3(sd * normal(engine), sd * normal(engine), sd * normal(engine)); };
  const auto printed = [](double x) { return 1e-11 * std::round(1e11 * x); };
  const Quat tilted = exp_quat(Vec3(0.08, -0.05, 0.0));
  io::Recording table;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i, half = -0.5 * (1.7 * std::cos(0.9 * t) + 0.5 * std::cos(2.3 * t));
    const Vec3 w(0, 0, 1.53 * std::sin(0.9 * t) + 1.15 * std::sin(2.3 * t));
    const Vec3 turns_faster(0, 0, 1.377 * std::cos(0.9 * t) + 2.645 * std::cos(2.3 * t));
    table.t_ns.push_back(10'000'000LL * i);
    const Quat q = tilted * Quat(std::cos(half), 0.0, 0.0, std::sin(half));
    table.ref_q_world_body.push_back(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()).unaryExpr(printed));
    table.ref_position_m.push_back(Vec3::Zero());
    table.acc_mps2.push_back(q.conjugate() * Vec3(0, 0, config.gravity_mps2) + turns_faster.cross(r) +
                             w.cross(w.cross(r)) + noise(0.005));
    table.gyr_radps.push_back(w + noise(5e-4));
  }
  const Answer answer = diagnose(table, config);
  ASSERT_THAT(names(answer), testing::Contains("acc_lever"));
  const Finding& lever = *finding(answer, "acc_lever");
  EXPECT_NEAR(number(lever, "r_x"), r[0], 1e-3);
  EXPECT_NEAR(number(lever, "r_y"), r[1], 1e-3);
  EXPECT_LT(std::abs(number(lever, "r_z")), 0.1);
}

/// Of an axis that nothing turns about, the residual is all of the reading: a scale of 2 fits, and what a map of such
/// scales is nearest to is half a turn of the mount.
TEST(Untold, AnOffsetThatWandersIsNoTurnOfTheMount) {
  const auto config = baseline("exact", 60.0);
  auto signals = make_signals(record(config, "", {}, 7), config, {});
  ASSERT_TRUE(signals);
  signals->exact_reference = false;  // as beside a camera, each sensor stands for its own truth
  signals->present[kMag] = false;
  for (const Sensor k : {kAcc, kGyr}) {
    const double size = k == kAcc ? 9.8 : 1.0;
    for (Eigen::Index i = 0; i < signals->n; ++i) {
      const double t = signals->t_s[i];
      const Vec3 table(0, 0, size * std::sin(0.9 * t)), wanders(std::sin(0.31 * t), std::cos(0.47 * t), 0);
      signals->predicted[k].row(i) = table;
      signals->residual[k].row(i) = 0.05 * size * wanders + 1e-3 * size * signals->residual[kGyr].row(i).transpose();
      signals->vector[k].row(i) = table + 0.05 * size * wanders;
    }
    signals->reading[k] = signals->predicted[k] + signals->residual[k];
  }
  Answer answer;
  find_frame(*signals, config, answer);
  EXPECT_THAT(names(answer), testing::IsEmpty());
}

}  // namespace
}  // namespace stillpoint::diag::test

/// A log of another simulator in the place of ours: the same answer, whatever its clock; what cannot be compared is
/// refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/foreign/foreign.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

constexpr std::uint64_t kSeed = 7;

sim::SimulationConfig scene() {
  sim::SimulationConfig s = test::baseline("none", 70.0);
  for (auto* triad : {&s.accelerometer, &s.gyroscope, &s.magnetometer}) (*triad)->bias.setZero();
  return s;
}

/// What another program would say of the same motion: another rate, a clock that began earlier, no reference.
io::Recording their_log(double noise = 1e-4) {
  sim::SimulationConfig s = scene();
  s.rate_hz = 83;
  for (auto* triad : {&s.accelerometer, &s.gyroscope, &s.magnetometer}) (*triad)->noise_sd *= noise;
  io::Recording log = test::record(s, "", {}, kSeed);
  for (auto& t : log.t_ns) t += 12'345'678'901;
  log.temp_degC.clear(), log.current_A.clear(), log.supply_V.clear();
  return log;
}

io::Recording ours(const std::string& id, const test::Parameters& parameters) {
  return test::record(scene(), id, parameters, kSeed);
}

io::Recording beside_a_reference(const std::string& id, const test::Parameters& parameters) {
  sim::SimulationConfig s = scene();
  s.reference.kind = "exact";
  return test::record(s, id, parameters, kSeed);
}

void keep_from(io::Recording& r, std::size_t first) {
  const auto cut = [first](auto& column) {
    if (!column.empty()) column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(first));
  };
  cut(r.t_ns), cut(r.acc_mps2), cut(r.gyr_radps), cut(r.mag_uT);
}

std::string refusal(const io::Recording& log) {
  const auto found = diagnose_log(log, ours("", {}));
  return found ? "accepted" : found.error().message;
}

TEST(ForeignLog, GivesTheSameNameAsOurOwnSimulation) {
  const auto found =
      diagnose_log(their_log(), ours("gyr_gsens", {{"G_radps_per_mps2", {4e-4, 0, 0, 0, -3e-4, 0, 0, 0, 5e-4}}}));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::Contains("gyr_gsens")) << found->answer.diagnosis.summary;
}

/// The recording's reference keeps the time of the motion: a late gyroscope is not two sensors that are early.
TEST(ForeignLog, TakesItsTimeFromTheReferenceWhereTheGyroscopeIsLate) {
  const auto found = diagnose_log(their_log(), beside_a_reference("gyr_delay", {{"tau_s", {0.012}}}));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::ElementsAre("gyr_delay")) << found->answer.diagnosis.summary;
}

TEST(ForeignLog, TakesItsTimeFromTheReferenceWhereTheSensorsClockRuns) {
  const auto found = diagnose_log(their_log(), beside_a_reference("sys_skew", {{"eps_ppm", {400}}}));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::ElementsAre("sys_skew")) << found->answer.diagnosis.summary;
}

TEST(ForeignLog, WithNothingMissingIsNoMismatch) {
  const auto found = diagnose_log(their_log(), ours("", {}));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::IsEmpty()) << found->answer.diagnosis.summary;
}

/// A log brings noise of its own, and so do the columns that are fitted to it: beside a reference without noise they
/// would be a field of the world that is nothing but this noise.
TEST(ForeignLog, AsNoisyAsTheRecordingIsNoMismatch) {
  const auto found = diagnose_log(their_log(1.0), beside_a_reference("", {}));
  ASSERT_TRUE(found) << found.error().message;
  const Diagnosis& d = found->answer.diagnosis;
  EXPECT_THAT(test::names(found->answer), testing::IsEmpty()) << d.summary;
  EXPECT_TRUE(d.configuration.empty()) << d.configuration.front().sensor << ": " << d.configuration.front().what;
  EXPECT_TRUE(d.noise.empty()) << d.summary;
}

TEST(ForeignLog, HalfAsNoisyAsTheRecordingAndWithoutAReferenceIsNoMismatch) {
  const auto found = diagnose_log(their_log(0.5), ours("", {}));
  ASSERT_TRUE(found) << found.error().message;
  const Diagnosis& d = found->answer.diagnosis;
  EXPECT_THAT(test::names(found->answer), testing::IsEmpty()) << d.summary;
  EXPECT_TRUE(d.configuration.empty()) << d.configuration.front().sensor << ": " << d.configuration.front().what;
}

/// Rows between those in which it was read are filled: they have no noise of their own, and it is not told as less.
TEST(ForeignLog, ASensorOfEverySecondRowHasItsOwnNoise) {
  io::Recording recording = beside_a_reference("", {});
  for (std::size_t i = 1; i < recording.size(); i += 2) recording.mag_uT[i].setConstant(io::kMissing);
  const auto found = diagnose_log(their_log(), recording);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::IsEmpty()) << found->answer.diagnosis.summary;
  EXPECT_THAT(found->answer.diagnosis.noise, testing::IsEmpty());
}

TEST(ForeignLog, BesideAReferenceOfSlowerFramesComparesEveryRow) {
  io::Recording recording =
      beside_a_reference("mag_soft_step", {{"t0_s", {35}}, {"M", {0.04, 0, 0, 0, -0.03, 0, 0, 0, 0.02}}});
  for (std::size_t i = 1; i < recording.size(); i += 2) {
    recording.ref_q_world_body[i].setConstant(io::kMissing);
    recording.ref_position_m[i].setConstant(io::kMissing);
  }
  const auto found = diagnose_log(their_log(), recording);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::Contains("mag_soft_step")) << found->answer.diagnosis.summary;
}

TEST(ForeignLog, ClockIsFoundThoughTheLogBeginsLater) {
  io::Recording log = their_log();
  keep_from(log, 830);
  const auto aligned = align(log, ours("", {}));
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_NEAR(aligned->offset_s, -10.0, 1e-4);
  EXPECT_NEAR(aligned->drift, 0.0, 1e-5);
  EXPECT_EQ(aligned->unread[kGyr].front(), 1);
}

TEST(ForeignLog, WithTheFoundPhysicsInItLeavesNothingToFind) {
  const io::Recording recording = ours("gyr_gsens", {{"G_radps_per_mps2", {4e-4, 0, 0, 0, -3e-4, 0, 0, 0, 5e-4}}});
  const auto first = diagnose_log(their_log(), recording);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_FALSE(first->answer.effects.empty()) << first->answer.diagnosis.summary;
  const auto second = diagnose_log(first->improved, recording);
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_THAT(test::names(second->answer), testing::IsEmpty()) << second->answer.diagnosis.summary;
}

/// What the log does not say, what was made of it does not say either: the rest is compared again.
TEST(ForeignLog, ThatBeginsLaterIsComparedAgainWhenImproved) {
  io::Recording log = their_log();
  keep_from(log, 830);
  const io::Recording recording = ours("gyr_gsens", {{"G_radps_per_mps2", {4e-4, 0, 0, 0, -3e-4, 0, 0, 0, 5e-4}}});
  const auto first = diagnose_log(log, recording);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_FALSE(first->improved.gyr_radps.front().allFinite());
  const auto second = diagnose_log(first->improved, recording);
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_THAT(test::names(second->answer), testing::IsEmpty()) << second->answer.diagnosis.summary;
}

/// The rows of a log from one second up to another, by their number.
std::pair<std::size_t, std::size_t> rows_between(const io::Recording& log, double from_s, double to_s) {
  std::size_t first = 0, last = 0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    const double t = log.t_s(i) - log.t_s(0);
    first += t < from_s ? 1 : 0, last += t < to_s ? 1 : 0;
  }
  return {first, last};
}

/// How many rows from one second up to another the log says nothing of.
std::ptrdiff_t unread_between(const AlignedLog& aligned, Sensor k, double from_s, double to_s) {
  const auto [first, last] = rows_between(aligned.reference, from_s, to_s);
  const auto begin = aligned.unread[k].begin();
  return std::count(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last), 1);
}

TEST(ForeignLog, WithLostRowsIsComparedInTheOthers) {
  io::Recording log = their_log();
  const auto [first, last] = rows_between(log, 30.0, 37.0);
  const auto lose = [first, last](auto& column) {
    column.erase(column.begin() + static_cast<std::ptrdiff_t>(first),
                 column.begin() + static_cast<std::ptrdiff_t>(last));
  };
  lose(log.t_ns), lose(log.acc_mps2), lose(log.gyr_radps), lose(log.mag_uT);
  const io::Recording recording = ours("", {});
  const auto aligned = align(log, recording);
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_EQ(unread_between(*aligned, kMag, 30.5, 36.5), 6 * 50);
  EXPECT_EQ(unread_between(*aligned, kMag, 10.0, 29.0), 0);
  const auto found = diagnose_log(log, recording);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(test::names(found->answer), testing::IsEmpty()) << found->answer.diagnosis.summary;
}

TEST(ForeignLog, OfWhichOneSensorPausesIsComparedInTheOthers) {
  for (const double pause_s : {0.35, 7.0}) {
    io::Recording log = their_log();
    const auto [first, last] = rows_between(log, 30.0, 30.0 + pause_s);
    for (std::size_t i = first; i < last; ++i) log.gyr_radps[i].setConstant(io::kMissing);
    const auto aligned = align(log, beside_a_reference("", {}));
    ASSERT_TRUE(aligned) << aligned.error().message;
    EXPECT_GE(unread_between(*aligned, kGyr, 29.9, 30.1 + pause_s), std::lround(50 * pause_s));
    EXPECT_EQ(unread_between(*aligned, kAcc, 29.0, 40.0), 0);
    const auto found = diagnose_log(log, beside_a_reference("", {}));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_THAT(test::names(found->answer), testing::IsEmpty()) << found->answer.diagnosis.summary;
  }
}

double largest(const std::vector<Vec3>& column) {
  double out = 0.0;
  for (const Vec3& v : column)
    if (v.allFinite()) out = std::max(out, v.cwiseAbs().maxCoeff());
  return out;
}

TEST(ForeignLog, ImprovedReadsWithinTheRailsThatWereFound) {
  const io::Recording recording = beside_a_reference("gyr_sat", {{"L_radps", {2.5, 2.5, 2.5}}});
  const auto found = diagnose_log(their_log(), recording);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_THAT(test::names(found->answer), testing::Contains("gyr_sat")) << found->answer.diagnosis.summary;
  EXPECT_GT(largest(their_log().gyr_radps), 2.6);
  EXPECT_NEAR(largest(found->improved.gyr_radps), 2.5, 1e-3);
  EXPECT_THAT(found->not_improved, testing::IsEmpty());
  const auto again = diagnose_log(found->improved, recording);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_THAT(test::names(again->answer), testing::IsEmpty()) << again->answer.diagnosis.summary;
}

TEST(ForeignLog, ImprovedRepeatsWhereASlowerMagnetometerDoes) {
  const io::Recording recording = ours("mag_hold", {{"n", {5}}});
  const auto found = diagnose_log(their_log(), recording);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_THAT(test::names(found->answer), testing::Contains("mag_hold")) << found->answer.diagnosis.summary;
  std::size_t repeats = 0, otherwise = 0;
  for (std::size_t i = 1; i < recording.size(); ++i) {
    const auto repeated = [i](const io::Recording& r) { return r.mag_uT[i] == r.mag_uT[i - 1]; };
    ++(repeated(recording) == repeated(found->improved) ? repeats : otherwise);
  }
  EXPECT_LT(otherwise, repeats / 100);
}

TEST(ForeignLog, ImprovedLacksByNameWhatNoNumberPredicts) {
  const auto found = diagnose_log(their_log(), beside_a_reference("sys_dup", {{"fraction", {0.02}}}));
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_THAT(test::names(found->answer), testing::Contains("sys_dup")) << found->answer.diagnosis.summary;
  EXPECT_THAT(found->not_improved, testing::Contains(testing::StartsWith("sys_dup is not in the improved log")));
}

TEST(ForeignLog, InAnotherUnitOfTimeIsNamedAtOnce) {
  for (const double times : {1e6, 1e3, 1e-3, 1e-6}) {
    io::Recording log = their_log();
    for (auto& t : log.t_ns) t = std::llround(static_cast<double>(t) * times);
    EXPECT_THAT(refusal(log), testing::HasSubstr("likely in another unit")) << times;
  }
}

TEST(ForeignLog, WithANegatedAccelerometerIsNamed) {
  io::Recording log = their_log();
  for (Vec3& f : log.acc_mps2) f = -f;
  EXPECT_THAT(refusal(log),
              testing::AllOf(testing::HasSubstr("accelerometer negated"), testing::HasSubstr("multiply by -1")));
}

TEST(ForeignLog, InDegreesIsNamed) {
  io::Recording log = their_log();
  for (Vec3& w : log.gyr_radps) w *= 57.29578;
  EXPECT_THAT(refusal(log), testing::HasSubstr("deg/s"));
}

TEST(ForeignLog, WithOtherAxesIsNamedWithTheMountThatTurnsThem) {
  io::Recording log = their_log();
  for (Vec3& w : log.gyr_radps) w = Vec3(w.y(), -w.x(), w.z());
  EXPECT_THAT(refusal(log), testing::HasSubstr("-y +x +z"));
}

TEST(ForeignLog, OfAnotherMotionIsRefused) {
  sim::SimulationConfig s = scene();
  EXPECT_THAT(refusal(test::record(s, "", {}, kSeed + 1)), testing::HasSubstr("another motion"));
}

TEST(ForeignLog, ThatPartsFromTheRecordingIsRefusedWithTheTime) {
  io::Recording log = their_log();
  for (std::size_t i = 0; i < log.size(); ++i)
    if (log.t_s(i) - log.t_s(0) > 40.0) log.gyr_radps[i] = Vec3(-log.gyr_radps[i].z(), log.gyr_radps[i].x(), 0.3);
  const std::string why = refusal(log);
  EXPECT_THAT(why, testing::HasSubstr("part at"));
  EXPECT_TRUE(why.find("at 38") != std::string::npos || why.find("at 40") != std::string::npos ||
              why.find("at 42") != std::string::npos)
      << why;
}

/// Rows from one second on at rest: the rate is noise.
void rest_from(io::Recording& r, double from_s, double noise) {
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal(0.0, noise);
  for (std::size_t i = 0; i < r.size(); ++i)
    if (r.t_s(i) - r.t_s(0) > from_s) r.gyr_radps[i] = {normal(random), normal(random), normal(random)};
}

TEST(ForeignLog, ThatRestsWhereTheRecordingRestsIsTheSameMotion) {
  io::Recording log = their_log(), recording = ours("", {});
  rest_from(log, 25.0, 1e-5), rest_from(recording, 25.0, 1e-3);
  const auto aligned = align(log, recording);
  EXPECT_TRUE(aligned) << aligned.error().message;
}

TEST(ForeignLog, AboutOneAxisOnlyIsOfTheSameAxesAndUnit) {
  io::Recording log = their_log(), recording = ours("", {});
  std::normal_distribution<double> normal(0.0, 1e-3);
  std::mt19937_64 random(kSeed);
  for (io::Recording* r : {&log, &recording})
    for (Vec3& w : r->gyr_radps) w.head<2>() = Eigen::Vector2d(normal(random), 3.0 * normal(random));
  const auto aligned = align(log, recording);
  EXPECT_TRUE(aligned) << aligned.error().message;
}

TEST(ForeignLog, ThatMovesWhereTheRecordingRestsIsRefusedWithTheTime) {
  io::Recording recording = ours("", {});
  rest_from(recording, 52.0, 1e-3);
  const auto aligned = align(their_log(), recording);
  ASSERT_FALSE(aligned);
  EXPECT_THAT(aligned.error().message, testing::HasSubstr("part at 5"));
}

TEST(ForeignLog, ThatIsNoisierThanTheRecordingIsTold) {
  const auto aligned = align(their_log(2.0), ours("", {}));
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_THAT(aligned->notices, testing::Contains(testing::HasSubstr("twice")));
}

}  // namespace
}  // namespace stillpoint::diag

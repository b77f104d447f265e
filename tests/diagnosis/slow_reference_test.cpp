/// A reference that is slower than the sensors, in every form that recordings have it, and clocks that are not even:
/// the answer is that of the same recording without them.
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "diagnosis/sanity/readings.h"
#include "diagnosis/sanity/rows.h"
#include "diagnosis/sanity/rows_with_reference.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const test::Parameters kThermal{{"k_radps_per_K", {6e-4, -3e-4, 2e-4}}};

io::Recording recorded(const std::string& reference, const std::string& id = "", const test::Parameters& p = {}) {
  auto config = test::baseline(reference, 60.0);
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  return test::record(config, id, p, 41);
}

void forget(io::Recording& r, std::size_t row) {
  r.ref_q_world_body[row].setConstant(io::kMissing), r.ref_position_m[row].setConstant(io::kMissing);
}

io::Recording with_frames_on_every(std::size_t step, io::Recording r) {
  for (std::size_t i = 0; i < r.size(); ++i)
    if (i % step != 0) forget(r, i);
  return r;
}

/// Straight lines between frames that do not fall on rows.
io::Recording drawn_between_frames(double rows_a_frame, io::Recording r) {
  const std::vector<Eigen::Vector4d> given = r.ref_q_world_body;
  const auto at = [&](double row) {
    const auto i = std::min(static_cast<std::size_t>(row), given.size() - 2);
    const Eigen::Vector4d next = given[i + 1] * (given[i].dot(given[i + 1]) < 0 ? -1.0 : 1.0);
    return Eigen::Vector4d(given[i] + (row - static_cast<double>(i)) * (next - given[i]));
  };
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double frame = std::floor(static_cast<double>(i) / rows_a_frame) * rows_a_frame;
    const Eigen::Vector4d a = at(frame),
                          b = at(frame + rows_a_frame) * (at(frame + rows_a_frame).dot(a) < 0 ? -1.0 : 1.0);
    r.ref_q_world_body[i] = (a + (static_cast<double>(i) - frame) / rows_a_frame * (b - a)).normalized();
  }
  return r;
}

io::Recording held_over(std::size_t step, io::Recording r) {
  for (std::size_t i = 0; i < r.size(); ++i)
    r.ref_q_world_body[i] = r.ref_q_world_body[i - i % step], r.ref_position_m[i] = r.ref_position_m[i - i % step];
  return r;
}

/// Each frame in a row of its own, a nanosecond before the row of the sensors.
io::Recording with_rows_of_its_own(const io::Recording& r) {
  io::Recording out;
  const Vec3 nothing = Vec3::Constant(io::kMissing);
  for (std::size_t i = 2; i < r.size(); ++i) {
    if (i % 2 == 0) {
      out.t_ns.push_back(r.t_ns[i] - 1), out.temp_degC.push_back(io::kMissing);
      out.acc_mps2.push_back(nothing), out.gyr_radps.push_back(nothing), out.mag_uT.push_back(nothing);
      out.ref_q_world_body.push_back(r.ref_q_world_body[i]), out.ref_position_m.push_back(r.ref_position_m[i]);
    }
    out.t_ns.push_back(r.t_ns[i]), out.temp_degC.push_back(r.temp_degC[i]);
    out.acc_mps2.push_back(r.acc_mps2[i]), out.gyr_radps.push_back(r.gyr_radps[i]), out.mag_uT.push_back(r.mag_uT[i]);
    out.ref_q_world_body.push_back(Eigen::Vector4d::Constant(io::kMissing)), out.ref_position_m.push_back(nothing);
  }
  return out;
}

/// An attitude drawn as lines errs where the body speeds up, and a good magnetometer shows that: it is none of its
/// physics.
TEST(SlowReference, ThatIsDrawnAsLinesBetweenFramesThatAreNoRowsIsNoPhysicsOfTheMagnetometer) {
  auto config = test::baseline("mocap", 60.0);
  config.magnetometer->noise_sd = 0.03;
  for (const std::uint64_t seed : {1, 2, 3})
    for (const Finding& f :
         diagnose(drawn_between_frames(5.0 / 3.0, test::record(config, "", {}, seed)), config).diagnosis.findings)
      EXPECT_THAT(f.channels, Not(Contains(HasSubstr("mag")))) << seed << ": " << f.effect;
}

/// What bridges a gap of the reference is no attitude, nor is what a filter makes of it beside the gap.
TEST(SlowReference, ThatWasLostInAMotionIsNoPhysicsOfTheMagnetometer) {
  auto config = test::baseline("mocap", 60.0);
  config.magnetometer->noise_sd = 0.03;
  config.motion->kind = "rest_poses";
  for (const std::uint64_t seed : {1, 2, 3}) {
    io::Recording r = test::record(config, "", {}, seed);
    for (std::size_t i = 0; i < r.size(); ++i)
      if (i % 400 < 40 && i > 100) forget(r, i);
    EXPECT_THAT(test::names(diagnose(r, config)), Not(Contains(HasSubstr("mag_")))) << seed;
  }
}

TEST(SlowReference, IsInterpolatedBetweenItsFramesAndNotAcrossABreak) {
  const io::Recording whole = recorded("exact");
  io::Recording slow = with_frames_on_every(2, whole);
  for (std::size_t i = 1000; i < 1050; ++i) forget(slow, i);
  for (std::size_t i = 0; i < slow.size(); i += 6) slow.ref_q_world_body[i] *= -1.0;
  std::vector<std::string> notices;
  const auto out = rows_with_reference(slow, notices).changed;
  ASSERT_TRUE(out);
  EXPECT_THAT(notices, ElementsAre(HasSubstr("25 frames a second beside 50 rows")));
  ASSERT_EQ(out->size(), whole.size());
  for (std::size_t i = 20; i + 20 < whole.size(); ++i) {
    const bool away = i < 980 || i > 1070;
    if (i > 1000 && i < 1049) {
      EXPECT_FALSE(out->ref_q_world_body[i].allFinite()) << i;
    } else if (away) {  // 3e-5 rad is what a gyroscope of 0.001 rad/s turns by in a row and a half
      EXPECT_GT(std::abs(out->ref_q_world_body[i].dot(whole.ref_q_world_body[i])), 1.0 - 1e-10) << i;
      EXPECT_LT((out->ref_position_m[i] - whole.ref_position_m[i]).norm(), 1e-5) << i;
    }
  }
}

TEST(SlowReference, EveryFormOfItGivesTheAnswerOfTheWholeOne) {
  for (const std::string reference : {"exact", "mocap"}) {
    const auto config = test::baseline(reference, 60.0);
    const io::Recording clean = recorded(reference), warm = recorded(reference, "gyr_temp_lin", kThermal);
    EXPECT_THAT(test::names(diagnose(with_frames_on_every(2, clean), config)), IsEmpty()) << reference;
    EXPECT_THAT(test::names(diagnose(held_over(2, clean), config)), IsEmpty()) << reference;
    EXPECT_THAT(test::names(diagnose(with_frames_on_every(3, warm), config)), ElementsAre("gyr_temp_lin")) << reference;
    EXPECT_THAT(test::names(diagnose(held_over(2, warm), config)), ElementsAre("gyr_temp_lin")) << reference;
    EXPECT_THAT(test::names(diagnose(with_rows_of_its_own(warm), config)), ElementsAre("gyr_temp_lin")) << reference;
  }
}

TEST(SlowReference, ACameraThatFreezesIsNotComparedMeanwhile) {
  io::Recording r = recorded("exact");
  std::size_t begin = 600;
  while (r.gyr_radps[begin].norm() < 1.0 || r.gyr_radps[begin + 50].norm() < 1.0) ++begin;
  for (std::size_t i = begin; i < begin + 100; ++i)
    r.ref_q_world_body[i] = r.ref_q_world_body[begin], r.ref_position_m[i] = r.ref_position_m[begin];
  const Answer answer = diagnose(r, test::baseline("exact", 60.0));
  EXPECT_THAT(test::names(answer), IsEmpty());
  EXPECT_THAT(answer.diagnosis.notices, testing::Contains(HasSubstr("in 99 rows it repeats itself")));
}

TEST(SlowReference, TooFewFramesAreNotInterpolated) {
  const auto config = test::baseline("exact", 60.0);
  const Answer answer = diagnose(held_over(10, recorded("exact")), config);
  EXPECT_EQ(answer.diagnosis.verdict, Verdict::kInsufficientData);
  EXPECT_THAT(answer.diagnosis.notices, testing::Contains(HasSubstr("too few to know the motion between them")));
}

/// Each sensor at its own stamps, a reading a row: the accelerometer in every second row of the recording, the
/// gyroscope half a step later, the reference and the temperature in rows of their own.
io::Recording a_reading_a_row(const std::string& id, const test::Parameters& p) {
  auto config = test::baseline("exact", 60.0);
  config.rate_hz = 200.0;
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  const io::Recording r = test::record(config, id, p, 41);
  io::Recording out = detail::without_rows(r);
  for (std::size_t i = 0; i < r.size(); ++i) {
    detail::append_row(r, i, out);
    const std::size_t row = out.size() - 1, turn = i % 4;
    out.mag_uT[row].setConstant(io::kMissing);
    if (turn != 0) out.acc_mps2[row].setConstant(io::kMissing);
    if (turn != 2) out.gyr_radps[row].setConstant(io::kMissing);
    if (turn != 3) forget(out, row);
    if (i % 401 != 1) out.temp_degC[row] = io::kMissing;
  }
  out.mag_uT.clear();
  return out;
}

TEST(InertialInRowsOfTheirOwn, AreComparedOnTheRowsOfOne) {
  auto config = test::baseline("exact", 60.0);
  config.magnetometer.reset();
  const Answer clean = diagnose(a_reading_a_row("", {}), config);
  EXPECT_THAT(test::names(clean), IsEmpty());
  EXPECT_EQ(clean.diagnosis.verdict, Verdict::kNoMismatch) << clean.diagnosis.summary;
  EXPECT_THAT(clean.diagnosis.notices, testing::Contains(HasSubstr("acc and gyr were read in rows of their own")));
  EXPECT_THAT(test::names(diagnose(a_reading_a_row("gyr_temp_lin", kThermal), config)), ElementsAre("gyr_temp_lin"));
  EXPECT_THAT(test::names(diagnose(a_reading_a_row("acc_lever", {{"r_m", {0.03, -0.02, 0.04}}}), config)),
              ElementsAre("acc_lever"));
}

/// Each reading of the field in a row of its own, half way between those of the other sensors; of them one in `step`.
io::Recording field_apart(const std::string& id, const test::Parameters& p, std::size_t step = 1) {
  auto config = test::baseline("exact", 60.0);
  config.rate_hz = 100.0;
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  io::Recording r = test::record(config, id, p, 41), out = detail::without_rows(r);
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (i % 2 == 0) r.mag_uT[i].setConstant(io::kMissing);
    if (i % 2 == 1) r.acc_mps2[i] = r.gyr_radps[i] = Vec3::Constant(io::kMissing), forget(r, i);
    if (i % 2 == 0 || i % (2 * step) == 1) detail::append_row(r, i, out);
  }
  return out;
}

TEST(FieldInRowsOfItsOwn, IsComparedWhereItIsAsFastAsTheOthers) {
  const auto config = test::baseline("exact", 60.0);
  const Answer clean = diagnose(field_apart("", {}), config);
  EXPECT_THAT(test::names(clean), IsEmpty());
  EXPECT_EQ(clean.diagnosis.verdict, Verdict::kNoMismatch) << clean.diagnosis.summary;
  EXPECT_THAT(clean.diagnosis.notices,
              testing::Contains(HasSubstr("mag: 3000 readings stand in rows of their own between those of the other "
                                          "sensors; interpolated to those rows")));
  EXPECT_THAT(test::names(diagnose(field_apart("mag_temp_lin", {{"k_uT_per_K", {0.2, -0.1, 0.15}}}), config)),
              ElementsAre("mag_temp_lin"));
  EXPECT_THAT(test::names(diagnose(field_apart("gyr_temp_lin", kThermal), config)), ElementsAre("gyr_temp_lin"));
}

TEST(FieldInRowsOfItsOwn, IsComparedWithoutAReferenceToo) {
  io::Recording r = field_apart("", {});
  r.ref_q_world_body.clear(), r.ref_position_m.clear();
  const Answer answer = diagnose(r, test::baseline("none", 60.0));
  EXPECT_THAT(test::names(answer), IsEmpty());
  EXPECT_THAT(answer.diagnosis.notices, testing::Contains(HasSubstr("interpolated to those rows")));
  EXPECT_THAT(answer.diagnosis.notices, testing::Not(testing::Contains(HasSubstr("rows a second"))));
}

TEST(FieldInRowsOfItsOwn, IsSetAsideWhereItIsSlower) {
  const Answer answer = diagnose(field_apart("", {}, 2), test::baseline("exact", 60.0));
  EXPECT_THAT(test::names(answer), IsEmpty());
  EXPECT_THAT(answer.diagnosis.notices, testing::Contains(HasSubstr("25 a second beside 50, too few")));
  EXPECT_THAT(answer.diagnosis.summary, HasSubstr("not compared: mag"));
}

/// Stamps in whole milliseconds of a clock of 120 Hz: 8, 8, 9, ...; their median is 4 % off.
TEST(EvenStep, IsTheMeanWhereStampsAreRounded) {
  auto config = test::baseline("exact", 30.0);
  config.rate_hz = 120.0;
  io::Recording r = test::record(config, "", {}, 3);
  for (auto& t : r.t_ns) t = (t + 500'000) / 1'000'000 * 1'000'000;
  EXPECT_NEAR(r.median_step_s(), 0.008, 1e-12);
  EXPECT_NEAR(even_step_s(r), 1.0 / 120.0, 1e-6);
  EXPECT_THAT(test::names(diagnose(r, config)), IsEmpty());
}

TEST(EvenStep, LeavesOutWhatWasLost) {
  io::Recording r = recorded("exact");
  for (std::size_t i = 500; i < r.size(); ++i) r.t_ns[i] += 5'000'000'000;
  EXPECT_DOUBLE_EQ(even_step_s(r), 0.02);
}

TEST(LostRows, NowAndThenAndAtRandomAreNoPhysics) {
  const auto config = test::baseline("mocap", 60.0);
  std::mt19937 random(4);
  io::Recording r = recorded("mocap", "gyr_temp_lin", kThermal);
  for (std::size_t i = 0; i < r.size(); ++i) {  // single values that the writer could not print
    if (random() % 100 == 0) forget(r, i);
    if (random() % 100 == 0) r.gyr_radps[i].setConstant(io::kMissing);
    if (random() % 100 == 0) r.acc_mps2[i].setConstant(io::kMissing);
  }
  EXPECT_THAT(test::names(diagnose(r, config)), ElementsAre("gyr_temp_lin"));
}

}  // namespace
}  // namespace stillpoint::diag

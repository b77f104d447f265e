/// Each mistake is made on a recording that is right, and must be named; the right one must pass in silence.
#include "diagnosis/sanity/sanity.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/so3.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

using testing::HasSubstr;

constexpr double kStep_s = 0.02;

sim::SimulationConfig baseline() {
  sim::SimulationConfig s = test::sensors();
  s.rate_hz = 1 / kStep_s;
  return s;
}

/// A minute of tumbling about changing axes while the body swings through some decimetres.
io::Recording tumbling() {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sd) { return Vec3(sd * normal(engine), sd * normal(engine), sd * normal(engine)); };
  const auto config = baseline();
  io::Recording r;
  Quat q = exp_quat(Vec3(0.2, -0.4, 0.3));
  for (int i = 0; i < 3000; ++i) {
    const double t = i * kStep_s;
    const Vec3 rate(1.5 * std::sin(1.1 * t), 1.2 * std::cos(0.7 * t + 1), 1.8 * std::sin(0.5 * t + 2));
    const Vec3 p(0.2 * std::sin(2 * t), 0.1 * std::sin(3 * t + 1), 0.15 * std::cos(2.5 * t));
    const Vec3 a(-0.8 * std::sin(2 * t), -0.9 * std::sin(3 * t + 1), -0.9375 * std::cos(2.5 * t));
    r.t_ns.push_back(static_cast<std::int64_t>(std::llround(1e9 * t)));
    r.ref_q_world_body.emplace_back(q.w(), q.x(), q.y(), q.z());
    r.ref_position_m.push_back(p);
    r.acc_mps2.push_back(q.conjugate() * (a + Vec3(0, 0, config.gravity_mps2)) + noise(0.02));
    r.gyr_radps.push_back(rate + noise(0.001));
    r.mag_uT.push_back(q.conjugate() * config.field_world_uT + noise(0.3));
    q = q * exp_quat(rate * kStep_s);
  }
  return r;
}

Sanity checked(const io::Recording& r) { return check_input(r, baseline()); }

void expect_notice(const Sanity& s, const std::string& words) {
  ASSERT_THAT(s.notices, testing::SizeIs(1));
  EXPECT_THAT(s.notices[0], HasSubstr(words));
}

TEST(Sanity, IsSilentOnARightRecording) {
  const auto s = checked(tumbling());
  EXPECT_THAT(s.notices, testing::IsEmpty());
  EXPECT_FALSE(s.reference_unusable || s.nothing_usable || s.unusable[kAcc] || s.unusable[kGyr] || s.unusable[kMag]);
}

TEST(Sanity, NamesUnits) {
  auto r = tumbling();
  for (auto& a : r.acc_mps2) a /= 9.80665;
  EXPECT_TRUE(checked(r).unusable[kAcc]);
  expect_notice(checked(r), "g instead of m/s^2");
  r = tumbling();
  for (auto& m : r.mag_uT) m *= 10;
  expect_notice(checked(r), "milligauss");
  r = tumbling();
  for (auto& m : r.mag_uT) m *= 0.01;
  expect_notice(checked(r), "like gauss");
  r = tumbling();
  for (auto& g : r.gyr_radps) g *= 180 / M_PI;
  expect_notice(checked(r), "degrees per second");
  r.ref_q_world_body.clear(), r.ref_position_m.clear();
  expect_notice(checked(r), "degrees per second");
}

TEST(Sanity, AnIronThatTheSimulationKnowsIsNoUnit) {
  auto simulation = baseline();
  simulation.magnetometer->bias = Vec3(60, -745, 20);
  auto r = tumbling();
  for (auto& m : r.mag_uT) m += simulation.magnetometer->bias;
  EXPECT_THAT(check_input(r, simulation).notices, testing::IsEmpty());
  for (auto& m : r.mag_uT) m *= 10;
  expect_notice(check_input(r, simulation), "milligauss");
}

void scale(std::vector<Vec3>& readings, double factor) {
  for (Vec3& y : readings) y *= factor;
}

TEST(Sanity, NamesUnitsOfARateWithAndWithoutAReference) {
  const std::pair<double, const char*> mistakes[] = {{180 / M_PI, "degrees per second"},
                                                     {180e3 / M_PI, "milli-degrees"},
                                                     {60 / (2 * M_PI), "revolutions"},
                                                     {M_PI / 180, "divided by 57.3"},
                                                     {131 * 180 / M_PI, "raw counts"}};
  for (const auto& [factor, words] : mistakes) {
    for (const bool with_reference : {true, false}) {
      auto r = tumbling();
      scale(r.gyr_radps, factor);
      if (!with_reference) r.ref_q_world_body.clear(), r.ref_position_m.clear();
      const auto s = checked(r);
      EXPECT_TRUE(s.unusable[kGyr] && !s.reference_unusable) << words;
      ASSERT_THAT(s.mistakes, testing::SizeIs(1)) << words;
      EXPECT_THAT(s.mistakes[0], HasSubstr(words));
    }
  }
}

TEST(Sanity, NamesCountsUnitLengthAndExchangedSensors) {
  auto r = tumbling();
  scale(r.acc_mps2, 16384 / 9.80665);
  expect_notice(checked(r), "raw counts");
  r = tumbling();
  for (Vec3& m : r.mag_uT) m.normalize();
  expect_notice(checked(r), "unit length");
  r = tumbling();
  std::swap(r.acc_mps2, r.gyr_radps);
  const auto s = checked(r);
  EXPECT_TRUE(s.unusable[kAcc] && s.unusable[kGyr]);
  EXPECT_THAT(s.mistakes, testing::Contains(HasSubstr("exchanged")));
}

TEST(Sanity, NamesAClockThatCountsInAnotherUnit) {
  for (const double factor : {1e3, 1e-3, 60.0, 1 / kStep_s}) {  // the last: rows counted as seconds
    auto r = tumbling();
    for (auto& t : r.t_ns) t = static_cast<std::int64_t>(std::llround(static_cast<double>(t) * factor));
    const auto s = checked(r);
    EXPECT_TRUE(s.nothing_usable) << factor;
    EXPECT_THAT(s.mistakes, testing::ElementsAre(HasSubstr("unit"))) << factor;
  }
}

TEST(Sanity, NamesWhatIsWrongWithThePosition) {
  const auto says = [](auto&& change, const std::string& words) {
    auto r = tumbling();
    change(r.ref_position_m);
    const auto s = checked(r);
    EXPECT_TRUE(s.position_unusable && !s.reference_unusable) << words;
    ASSERT_THAT(s.mistakes, testing::SizeIs(1)) << words;
    EXPECT_THAT(s.mistakes[0], HasSubstr(words));
  };
  says([](auto& p) { scale(p, 1000); }, "millimetres");
  says([](auto& p) { scale(p, 39.37); }, "inches");
  says(
      [](auto& p) {
        for (Vec3& x : p) x = Vec3(x.y(), x.x(), -x.z());
      },
      "world x is position +y");
  says(
      [](auto& p) {
        for (Vec3& x : p) x.y() *= -1;
      },
      "world y is position -y");
  says([](auto& p) { std::rotate(p.begin(), p.end() - 40, p.end()); }, "it is 0.8");
  says(
      [](auto& p) {
        for (Vec3& x : p) x.setOnes();
      },
      "never changes");
  says(
      [](auto& p) {
        for (Vec3& x : p) x.setConstant(io::kMissing);
      },
      "fewer than 100 rows");
}

/// A sensor that reads half of gravity has a wrong number in its calibration; its position is not to blame.
TEST(Sanity, DoesNotBlameThePositionForAScale) {
  auto r = tumbling();
  scale(r.acc_mps2, 0.5);
  EXPECT_THAT(checked(r).mistakes, testing::IsEmpty());
}

TEST(Sanity, NamesAReferenceOfATurnedBody) {
  auto r = tumbling();
  for (auto* readings : {&r.acc_mps2, &r.gyr_radps, &r.mag_uT})
    for (Vec3& y : *readings) y = Vec3(-y.x(), -y.y(), y.z());
  EXPECT_TRUE(checked(r).reference_unusable);
  expect_notice(checked(r), "its body is turned");
}

TEST(Sanity, NamesAFieldThatDoesNotTurnWithTheBody) {
  auto r = tumbling();
  std::shuffle(r.mag_uT.begin(), r.mag_uT.end(), std::mt19937_64(3));
  EXPECT_TRUE(checked(r).unusable[kMag]);
  expect_notice(checked(r), "do not turn with the body");
}

TEST(Sanity, NamesTheConventionOfTheReference) {
  const Quat ned(0, std::sqrt(0.5), std::sqrt(0.5), 0);
  auto r = tumbling();
  for (auto& q : r.ref_q_world_body) q.tail<3>() *= -1;
  EXPECT_TRUE(checked(r).reference_unusable);
  expect_notice(checked(r), "conjugated");
  r = tumbling();
  for (auto& q : r.ref_q_world_body) q = Eigen::Vector4d(q[1], q[2], q[3], q[0]);
  expect_notice(checked(r), "x,y,z,w");
  r = tumbling();
  for (auto& q : r.ref_q_world_body) {
    const Quat turned = ned * Quat(q[0], q[1], q[2], q[3]);
    q = Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z());
  }
  for (auto& p : r.ref_position_m) p = Vec3(p.y(), p.x(), -p.z());
  expect_notice(checked(r), "north-east-down");
  r = tumbling();
  for (auto& q : r.ref_q_world_body) q[1] *= -1, q[3] *= -1;
  expect_notice(checked(r), "left-handed");
}

TEST(Sanity, NamesASensorWithOtherAxes) {
  auto r = tumbling();
  for (auto& a : r.acc_mps2) a *= -1;
  EXPECT_FALSE(checked(r).reference_unusable);
  expect_notice(checked(r), "gravity where specific force");
  r = tumbling();
  for (auto& g : r.gyr_radps) g.y() *= -1;
  expect_notice(checked(r), "left-handed");
}

TEST(Sanity, NamesAReferenceWithAnotherHeadingOrClock) {
  auto r = tumbling();
  const Quat turn(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  for (auto& q : r.ref_q_world_body) {
    const Quat turned = turn * Quat(q[0], q[1], q[2], q[3]);
    q = Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z());
  }
  for (auto& p : r.ref_position_m) p = turn * p;
  expect_notice(checked(r), "field_world_uT");
  r = tumbling();
  std::rotate(r.ref_q_world_body.begin(), r.ref_q_world_body.end() - 25, r.ref_q_world_body.end());
  std::rotate(r.ref_position_m.begin(), r.ref_position_m.end() - 25, r.ref_position_m.end());
  expect_notice(checked(r), "reference: it is 0.5");
}

TEST(Sanity, SaysWhatIsMissing) {
  auto r = tumbling();
  r.mag_uT.clear();
  expect_notice(checked(r), "no such columns");
  r = tumbling();
  for (auto& m : r.mag_uT) m.x() = 3.0;
  EXPECT_TRUE(checked(r).unusable[kMag]);
  r = tumbling();
  for (auto& g : r.gyr_radps) g.x() = io::kMissing;
  expect_notice(checked(r), "gyr_x: no reading in any row");
  r = tumbling();
  r.t_ns.resize(100);
  EXPECT_TRUE(checked(r).nothing_usable);
  r = tumbling();
  r.issues.backward_time = {.count = 9000, .first_line = 17};
  expect_notice(checked(r), "9000 rows were dropped, the first in line 17");
}

}  // namespace
}  // namespace stillpoint::diag

/// Who contradicts the attitude, and what the filter makes of it.
#include <algorithm>
#include <numbers>

#include "fusion/turn_witness.h"
#include "fusion/two_witnesses.h"
#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::RandomMotion;

constexpr double kPeriod_s = 0.05;
const Vec3 kGravity(0, 0, kStandardGravity_mps2), kField(0, 20, -43);

Vec3 leaning(const Vec3& v, double angle_rad) { return exp_quat(Vec3(angle_rad, 0, 0)) * v; }

/// Half a minute in which both stand still, but for a hand's acceleration.
TwoWitnesses heard() {
  TwoWitnesses w;
  for (int k = 0; k < 600; ++k) {
    w.observe(kGravity + Vec3(std::sin(0.7 * k), std::cos(0.4 * k), 0), kField, kPeriod_s);
    EXPECT_EQ(w.denied_rad2(), 0.0) << k;
  }
  return w;
}

TEST(TwoWitnesses, BothLeavingTheirPlacesDenyTheAttitude) {
  TwoWitnesses w = heard();
  int periods = 0;
  for (; periods < 100 && w.denied_rad2() == 0.0; ++periods)
    w.observe(leaning(kGravity, 0.5), leaning(kField, 0.5), kPeriod_s);
  EXPECT_LE(periods * kPeriod_s, 1.0);
  EXPECT_GT(std::sqrt(w.denied_rad2()), 0.1);
  EXPECT_LT(std::sqrt(w.denied_rad2()), 0.5);
}

TEST(TwoWitnesses, OneAloneIsAnAccelerationOrAMagnet) {
  TwoWitnesses braking = heard(), magnet = heard();
  for (int k = 0; k < 100; ++k) {
    braking.observe(leaning(kGravity, 0.5), kField, kPeriod_s);
    magnet.observe(kGravity, leaning(kField, 0.5), kPeriod_s);
    ASSERT_EQ(braking.denied_rad2(), 0.0) << k;
    ASSERT_EQ(magnet.denied_rad2(), 0.0) << k;
  }
}

TEST(TwoWitnesses, AFieldNoLongerHeardDeniesNothing) {
  TwoWitnesses w = heard();
  for (int k = 0; k < 20; ++k) w.observe(leaning(kGravity, 0.5), leaning(kField, 0.5), kPeriod_s);
  ASSERT_GT(w.denied_rad2(), 0.0);
  for (int k = 0; k < 25; ++k) w.observe(leaning(kGravity, 0.5), std::nullopt, kPeriod_s);
  EXPECT_EQ(w.denied_rad2(), 0.0);
}

/// The body turns to and fro about `axis`; the gyroscope says `factor` times as much.
bool denied(double factor, double moved_uT) {
  TurnWitness turns;
  for (int k = 0; k < 100; ++k) {
    const double angle = std::sin(0.1 * k);
    const Mat3 said = exp_so3(Vec3(factor * angle, 0, 0));
    const Vec3 body = exp_so3(Vec3(-angle, 0, 0)) * (kField + Vec3(moved_uT * std::sin(0.33 * k), 0, 0));
    turns.observe(said * body, said, kPeriod_s);
  }
  return turns.denied();
}

TEST(TurnWitness, AGyroscopeThatTurnsOtherwiseIsDenied) {
  EXPECT_FALSE(denied(1.0, 0.0));
  EXPECT_FALSE(denied(0.95, 1.0));
  EXPECT_TRUE(denied(-1.0, 0.0));
  EXPECT_TRUE(denied(2.0, 0.0));
}

TEST(TurnWitness, AFieldThatMovesIsDenied) { EXPECT_TRUE(denied(1.0, 100.0)); }

TEST(AttitudeWitnesses, SoundSensorsAreNeverDenied) {
  for (const double turn_radps : {0.3, 1.0, 3.0})
    for (unsigned seed = 1; seed <= 10; ++seed) {
      test::MotionParams params;
      params.turn_radps = turn_radps;
      RandomMotion motion(params, seed);
      AttitudeFilter filter;
      for (int i = 0; i < 6000; ++i) {
        const AttitudeEstimate e = filter.step(motion.next(i < 300), i < 300);
        ASSERT_FALSE(e.denied) << turn_radps << " rad/s, seed " << seed << ", sample " << i;
      }
    }
}

/// A fault that lasts for two minutes is denied in its last ten seconds as in its first.
TEST(AttitudeWitnesses, AFaultThatLastsIsNotGotUsedTo) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    RandomMotion motion({}, seed);
    AttitudeFilter filter;
    bool denied_late = false;
    for (int i = 0; i < 16000; ++i) {
      CalibratedSample s = motion.next(i < 300);
      if (i >= 4000) std::swap(s.gyr_radps[0], s.gyr_radps[1]);
      denied_late |= filter.step(s, i < 300).denied && i > 15000;
    }
    EXPECT_TRUE(denied_late) << seed;
  }
}

using Damage = void (*)(CalibratedSample&);

/// Seconds from the damage until the filter says that it is denied, the slowest of ten seeds.
double slowest_s(Damage damage) {
  double slowest = 0.0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    RandomMotion motion({}, seed);
    AttitudeFilter filter;
    int said = 0;
    for (int i = 0; i < 6000 && said == 0; ++i) {
      CalibratedSample s = motion.next(i < 300);
      if (i >= 4000) damage(s);
      if (filter.step(s, i < 300).denied) said = i - 4000;
    }
    slowest = std::max(slowest, said == 0 ? 1e9 : 0.01 * said);
  }
  return slowest;
}

TEST(AttitudeWitnesses, ASensorThatIsNoLongerTheOneKnownIsDeniedWithinSeconds) {
  EXPECT_LT(slowest_s([](CalibratedSample& s) { s.gyr_radps[0] *= -1.0; }), 6.0);
  EXPECT_LT(slowest_s([](CalibratedSample& s) { std::swap(s.gyr_radps[0], s.gyr_radps[1]); }), 6.0);
  EXPECT_LT(slowest_s([](CalibratedSample& s) { vec(s.gyr_radps) *= 2.0; }), 6.0);
  EXPECT_LT(slowest_s([](CalibratedSample& s) { s.gyr_radps[1] += 0.3; }), 6.0);
  EXPECT_LT(slowest_s([](CalibratedSample& s) { std::swap(s.acc_mps2[0], s.acc_mps2[2]); }), 10.0);
}

/// Twenty seconds without readings: what gravity and the field correct meanwhile is the attitude, no offset.
TEST(AttitudeWitnesses, AnAbsentGyroscopeTeachesNothingOfItsOffset) {
  test::MotionParams strong;
  strong.turn_radps = 2.0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    RandomMotion motion(strong, seed);
    AttitudeFilter filter;
    AttitudeEstimate e, before;
    for (int i = 0; i < 5000; ++i) {
      CalibratedSample s = motion.next(i < 500);
      if (i >= 2000 && i < 4000) s.has = static_cast<std::uint8_t>(s.has & ~kGyr);
      e = filter.step(s, i < 500);
      if (i == 1999) before = e;
      for (std::size_t k = 0; k < 3 && i >= 3999; ++k)
        ASSERT_LT(std::abs(e.gyro_bias_radps[k] - before.gyro_bias_radps[k]), 0.02) << seed << " sample " << i;
    }
  }
}

/// Tilt in rad, root mean square from row `from` on.
double tilt_rms(const test::MotionParams& params, unsigned seed, int rows, int from, int still, Damage damage) {
  RandomMotion motion(params, seed);
  AttitudeFilter filter;
  double sum = 0.0;
  for (int i = 0; i < rows; ++i) {
    CalibratedSample s = motion.next(i < still);
    if (i >= 4000) damage(s);
    const AttitudeEstimate e = filter.step(s, i < still);
    const double tilt = tilt_rad(test::error_world(motion.q_world_body(), quat(e.q_world_body)));
    if (i >= from) sum += tilt * tilt;
  }
  return std::sqrt(sum / (rows - from));
}

/// An offset that has changed contradicts the attitude until it is learnt: what is denied is not for ever.
TEST(AttitudeWitnesses, AnotherOffsetIsLearntInTheEnd) {
  const Damage another = [](CalibratedSample& s) { s.gyr_radps[0] -= 0.2, s.gyr_radps[1] += 0.3; };
  for (unsigned seed = 1; seed <= 8; ++seed) EXPECT_LT(tilt_rms({}, seed, 16000, 10000, 300, another), 0.1) << seed;
}

/// Iron larger than the horizontal field, and nobody has seen the body at rest: until the iron is known the field
/// steers the heading and spoils nothing else.
TEST(AttitudeWitnesses, AFieldThatDoesNotTurnWithTheBodyTiltsNothing) {
  test::MotionParams arm;
  arm.turn_radps = 4.0, arm.turn_time_s = 0.4;
  arm.hard_iron_uT = {27.0, -27.0, 22.5};
  for (unsigned seed = 1; seed <= 8; ++seed) {
    EXPECT_LT(tilt_rms(arm, seed, 4000, 1000, 0, nullptr), 0.06) << seed;
  }
}

}  // namespace
}  // namespace stillpoint::fusion

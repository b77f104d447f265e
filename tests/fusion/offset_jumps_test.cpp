/// An offset that jumps in motion: what a jump does to the estimate, and what the innovations make of it.
#include "fusion/offset_jumps.h"

#include "tests/fusion/attitude_testing.h"

namespace stillpoint::fusion {
namespace {

using test::MotionParams;
using test::RandomMotion;

/// A calibrated sensor, so that the jump is the only thing to find.
MotionParams calibrated() {
  MotionParams p;
  p.turn_radps = 0.3;
  p.turn_time_s = 3.0;
  p.speed_mps = 0.2;
  p.gyr_bias_sd_radps = 1e-4;
  p.gyr_matrix_sd = 1e-4;
  return p;
}

CalibratedSample shifted(CalibratedSample s, const Vec3& gyr_radps, const Vec3& acc_mps2) {
  vec(s.gyr_radps) += gyr_radps;
  vec(s.acc_mps2) += acc_mps2;
  return s;
}

struct Heard {
  Coverage tilt;
  double gyr_told_s = 1e9, acc_told_s = 1e9;  ///< since the jump, the first time
};

/// Ten seconds of rest and thirty of motion, then the jump, and twenty seconds more of motion.
Heard hear_jump(unsigned seed, const Vec3& gyr_radps, const Vec3& acc_mps2) {
  RandomMotion motion(calibrated(), seed);
  AttitudeFilter filter;
  Heard out;
  for (int i = 0; i < 6000; ++i) {
    const bool still = i < 1000, jumped = i >= 4000;
    const AttitudeEstimate e = filter.step(
        shifted(motion.next(still), jumped ? gyr_radps : Vec3::Zero(), jumped ? acc_mps2 : Vec3::Zero()), still);
    const double since_s = 0.01 * (i - 4000);
    if (e.gyro_offset_jumped) out.gyr_told_s = std::min(out.gyr_told_s, since_s);
    if (e.acc_offset_jumped) out.acc_told_s = std::min(out.acc_told_s, since_s);
    const double sd2 = e.covariance_world_rad2[0] + e.covariance_world_rad2[4];
    const double tilt = tilt_rad(test::error_world(motion.q_world_body(), quat(e.q_world_body)));
    if (jumped) out.tilt.note(tilt * tilt < 9.0 * sd2);
  }
  return out;
}

TEST(OffsetJumps, AJumpHasTurnedTheEstimateByWhatTheColumnsSay) {
  constexpr double kSize[] = {1e-5, 1e-4};  // rad/s, m/s^2: small, so that everything is a straight line
  AttitudeFilterParams without_field;       // the heading's start is a jump of its own
  without_field.use_magnetometer = false;
  for (int of = 0; of < 2; ++of)
    for (int axis = 0; axis < 3; ++axis) {
      const int jump = 2 + of;  // of the window that begins second
      const Vec3 size = kSize[of] * Vec3::Unit(axis);
      RandomMotion motion(calibrated(), 5);
      AttitudeFilter plain(without_field), jumping(without_field);
      AttitudeEstimate a, b;
      int since = 0;
      for (int i = 0; since < 601; ++i) {
        const CalibratedSample s = motion.next(false);
        a = plain.step(s, false);
        const bool begun = i > 1050 && (since > 0 || plain.error_state().turned_by_jump(jump).isZero(0.0));
        b = jumping.step(since > 0 ? shifted(s, (1 - of) * size, of * size) : s, false);
        since += begun;
      }
      const Vec3 turned = test::error_world(quat(a.q_world_body), quat(b.q_world_body));
      const Vec3 expected = plain.error_state().turned_by_jump(jump) * size;
      EXPECT_GT(expected.norm(), 0.01 * kSize[of]);
      EXPECT_LT((turned - expected).norm(), 0.05 * expected.norm()) << "jump " << jump << ", axis " << axis;
    }
}

TEST(OffsetJumps, OneOfTheGyroscopeIsToldInMotionAndStatedBefore) {
  Coverage tilt;
  int told = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Heard heard = hear_jump(seed, Vec3(0.0, kRadPerDeg, 0.0), Vec3::Zero());
    told += heard.gyr_told_s >= 0.0 && heard.gyr_told_s < 20.0 && heard.acc_told_s > 20.0;
    tilt.inside += heard.tilt.inside;
    tilt.judged += heard.tilt.judged;
  }
  EXPECT_GE(told, 18);
  EXPECT_GT(tilt.share(), 0.98);
}

TEST(OffsetJumps, OneOfTheAccelerometerIsToldToo) {
  Coverage tilt;
  int told = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Heard heard = hear_jump(seed, Vec3::Zero(), Vec3(2.0, 0.0, 0.0));
    told += heard.acc_told_s >= 0.0 && heard.acc_told_s < 20.0;
    tilt.inside += heard.tilt.inside;
    tilt.judged += heard.tilt.judged;
  }
  EXPECT_GE(told, 14);
  EXPECT_GT(tilt.share(), 0.9);  // 91 % in the drill too: a rest believes what it feels
}

TEST(OffsetJumps, NoneIsToldWhereNoneHasBeen) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Heard heard = hear_jump(seed, Vec3::Zero(), Vec3::Zero());
    EXPECT_EQ(heard.gyr_told_s, 1e9) << seed;
    EXPECT_EQ(heard.acc_told_s, 1e9) << seed;
  }
}

/// What an offset of 0.02 rad/s about x does within seven seconds, told by a body whose vertical keeps to `up` on
/// average, and that a vehicle carries or not.
struct Told {
  OffsetJumps::Verdict verdict = OffsetJumps::Verdict::kNone;
  double most_rad2 = 0.0, last_rad2 = 0.0;
};
Told tell_of_a_jump(const Vec3& up, bool carried = false) {
  Told told;
  ErrorState error;
  error.start(ErrorVector::Constant(1e-3));
  OffsetJumps jumps;
  jumps.restart(error);
  MotionSums sums;
  sums.time_s = 0.05;
  mat(sums.R) = 0.05 * Mat3::Identity();
  sums.force[2] = 0.05 * kStandardGravity_mps2;
  double lean_rad = 0.0, speed_mps = 0.0;
  for (int i = 0; i < 140 && told.verdict == OffsetJumps::Verdict::kNone; ++i) {
    error.propagate(sums, {});
    lean_rad += 0.02 * sums.time_s;  // gravity leans towards -y
    speed_mps += kStandardGravity_mps2 * lean_rad * sums.time_s;
    error.update(kVelocity + 1, -speed_mps, 2.0);
    told.verdict = jumps.observe(error, up, carried, sums.time_s);
    told.last_rad2 = mat(jumps.doubt_rad2())(0, 0);
    told.most_rad2 = std::max(told.most_rad2, told.last_rad2);
  }
  return told;
}

/// The doubt is stated before the jump is believed, and only then: what is believed is in the covariance itself.
TEST(OffsetJumps, BeforeItIsBelievedItIsStated) {
  const Told told = tell_of_a_jump(Vec3::Zero());
  EXPECT_EQ(told.verdict, OffsetJumps::Verdict::kGyroscope);
  EXPECT_GT(std::sqrt(told.most_rad2), 0.01);
  EXPECT_EQ(told.last_rad2, 0.0);
}

/// A vehicle that begins to accelerate looks like that to a body that does not turn.
TEST(OffsetJumps, OfABodyThatDoesNotTurnItIsStatedAndNotBelieved) {
  for (const Told& told : {tell_of_a_jump(Vec3::UnitZ()), tell_of_a_jump(Vec3::Zero(), true)}) {
    EXPECT_EQ(told.verdict, OffsetJumps::Verdict::kNone);
    EXPECT_GT(std::sqrt(told.last_rad2), 0.01);
  }
}

}  // namespace
}  // namespace stillpoint::fusion

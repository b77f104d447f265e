/// The turns of a whole recording, gone through again: as sure as the place is even, and no surer.
#include "calib_online/offline/field_again.h"

#include <gtest/gtest.h>

#include "core/so3.h"
#include "tests/calib_online/dice.h"

namespace stillpoint::calib {
namespace {

constexpr double kNoise_uT = 0.13;  // of the mean of a tenth of a second
const Vec3 kIron_uT(31.0, -24.0, 8.0), kLargeIron_uT(180.0, -200.0, 150.0);

/// Turns between poses in every direction; the place differs by `uneven_uT` from one to the next.
std::vector<FieldTurn> turns_between_poses(int count, double uneven_uT, unsigned seed, const Vec3& iron_uT) {
  Dice dice(seed);
  Quat q = dice.rotation();
  const auto reading = [&] {
    const Vec3 field = Vec3(0, 20, -43) + dice.normal3(uneven_uT);
    return array(Vec3(q.conjugate() * field + iron_uT + dice.normal3(kNoise_uT)));
  };
  std::vector<FieldTurn> out;
  Array3 last = reading();
  for (int k = 0; k < count; ++k) {
    const Vec3 turn = dice.normal3(1.0) + Vec3(0.4, 0.0, 0.0);
    const Quat by = exp_quat(turn);
    q = q * by;
    FieldTurn t;
    t.t_end_ns = 1'000'000'000LL * (k + 1);
    t.before_uT = last;
    t.after_uT = last = reading();
    t.q_before_after = {by.w(), by.x(), by.y(), by.z()};
    t.noise_uT2 = 2.0 * kNoise_uT * kNoise_uT;
    t.path_rad = turn.norm();
    t.time_s = 0.7;
    out.push_back(t);
  }
  return out;
}

TriadCalibration taught(int turns, double uneven_uT, unsigned seed, const Vec3& iron_uT = kIron_uT) {
  TriadCalibration out;
  learn_field(MagLearner({}, {}), turns_between_poses(turns, uneven_uT, seed, iron_uT), 1e-3, 1e-4).publish(out);
  return out;
}

TEST(FieldAgain, FiftyTurnsInAnEvenPlaceAreEnough) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TriadCalibration mag = taught(50, 0.0, seed);
    ASSERT_EQ(mag.status, CalibrationStatus::kOk) << seed;
    const Vec3 sd = mat(mag.bias_covariance).diagonal().cwiseSqrt();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(mag.bias[static_cast<std::size_t>(axis)], kIron_uT[axis], 3.0 * sd[axis]) << seed;
      EXPECT_LT(sd[axis], 0.3) << seed;
    }
  }
}

TEST(FieldAgain, LargeIronIsNoUnevenPlace) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TriadCalibration mag = taught(50, 0.0, seed, kLargeIron_uT);
    ASSERT_EQ(mag.status, CalibrationStatus::kOk) << seed;
    const Vec3 sd = mat(mag.bias_covariance).diagonal().cwiseSqrt();
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(mag.bias[static_cast<std::size_t>(axis)], kLargeIron_uT[axis], 3.0 * sd[axis]) << seed;
  }
}

TEST(FieldAgain, AnUnevenPlacePromisesNothing) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    EXPECT_EQ(taught(50, 1.5, seed).status, CalibrationStatus::kNotObservable) << seed;
}

TEST(FieldAgain, AFewTurnsAreNoPlace) {
  EXPECT_EQ(taught(8, 0.0, 1).status, CalibrationStatus::kTooFewWindows);
  EXPECT_EQ(taught(0, 0.0, 1).status, CalibrationStatus::kTooFewWindows);
}

}  // namespace
}  // namespace stillpoint::calib

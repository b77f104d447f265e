/// How sensors sit on a body: the maps, the mirrors, the stated deviations, and what cannot be known.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "calib_online/offline/axis_maps.h"
#include "calib_online/offline/mount_fit.h"
#include "calib_online/offline/mount_ways.h"
#include "tests/calib_online/mount_scene.h"

namespace stillpoint::calib {
namespace {

using namespace test;

const std::vector<Quat> kThreeSides{kLevel, kFrontUp, kLeftUp, kLevel};

Mat3 mirror(int axis) {
  Mat3 m = Mat3::Identity();
  m(axis, axis) = -1.0;
  return m;
}

TEST(AxisMaps, ThereAreTwentyFourAndNoneMirrors) {
  ASSERT_EQ(axis_maps().size(), 24U);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_DOUBLE_EQ(axis_maps()[i].determinant(), 1.0);
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(axis_maps()[i].isApprox(axis_maps()[j]));
    const Mat3 near = exp_so3(Vec3(0.2, -0.1, 0.3)) * axis_maps()[i];
    EXPECT_TRUE(nearest_axis_map(near).isApprox(axis_maps()[i]));
    EXPECT_TRUE(nearest_axis_map(-near).isApprox(-axis_maps()[i]));
  }
}

TEST(AxisMaps, AMirrorIsUndoneOnTheAxisThatLeavesTheLeastTurn) {
  for (int axis = 0; axis < 3; ++axis) {
    const Unmirrored right = unmirrored(exp_so3(Vec3(0.1, 0.1, -0.1)) * mirror(axis));
    EXPECT_EQ(right.sensor_axis, axis);
    EXPECT_TRUE(right.map.isIdentity());
    EXPECT_GT(right.turn.determinant(), 0.0);
  }
}

TEST(Mount, EveryMapOfEverySensorIsFoundByItsName) {
  for (std::size_t i = 0; i < 24; ++i) {
    const Sitting sitting{axis_maps()[i], axis_maps()[(7 * i + 3) % 24], axis_maps()[(5 * i + 11) % 24]};
    const MountFit found = fit(kThreeSides, sitting, static_cast<unsigned>(i), kUsual);
    ASSERT_TRUE(found.acc.known() && found.gyr.known() && found.mag.known())
        << i << name(found.acc.lack) << name(found.gyr.lack) << name(found.mag.lack);
    EXPECT_TRUE(named(found.acc.R, found.acc.covariance).map.isApprox(sitting.acc)) << i;
    EXPECT_TRUE(named(found.gyr.R, found.gyr.covariance).map.isApprox(sitting.gyr)) << i;
    EXPECT_TRUE(named(found.mag.R, found.mag.covariance).map.isApprox(sitting.mag)) << i;
    EXPECT_TRUE(found.gyr.mirror_excluded && found.mag.mirror_excluded) << i;
  }
}

TEST(Mount, AMirroredAxisIsRefusedAndNamed) {
  for (int axis = 0; axis < 3; ++axis) {
    const MountFit gyr = fit(kThreeSides, {Mat3::Identity(), mirror(axis), Mat3::Identity()}, 5, kUsual);
    EXPECT_EQ(gyr.gyr.lack, MountLack::kMirrored) << axis;
    EXPECT_EQ(unmirrored(gyr.gyr.R).sensor_axis, axis);
    EXPECT_TRUE(unmirrored(gyr.gyr.R).map.isIdentity());
    EXPECT_EQ(gyr.mag.lack, MountLack::kNone) << "the magnetometer is read with the gyroscope put right";
    const MountFit mag = fit(kThreeSides, {Mat3::Identity(), Mat3::Identity(), mirror(axis)}, 6, kUsual);
    EXPECT_EQ(mag.gyr.lack, MountLack::kNone);
    EXPECT_EQ(mag.mag.lack, MountLack::kMirrored) << axis;
    EXPECT_EQ(unmirrored(mag.mag.R).sensor_axis, axis);
    MountParams stated;
    stated.faces = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()};
    const MountFit acc = fit(kThreeSides, {mirror(axis), Mat3::Identity(), Mat3::Identity()}, 7, kUsual, stated);
    EXPECT_EQ(acc.acc.lack, MountLack::kMirrored) << axis;
    EXPECT_EQ(unmirrored(acc.acc.R).sensor_axis, axis);
    EXPECT_TRUE(fit(kThreeSides, {}, 7, kUsual, stated).acc.mirror_excluded);
  }
}

TEST(Mount, SouthOfTheEquatorTheSameFieldIsAMirroredOne) {
  MountParams south;
  south.north = false;
  EXPECT_EQ(fit(kThreeSides, {}, 8, {}, south).mag.lack, MountLack::kMirrored);
  EXPECT_EQ(fit(kThreeSides, {Mat3::Identity(), Mat3::Identity(), -Mat3::Identity()}, 8, {}, south).mag.lack,
            MountLack::kNone);
}

TEST(Mount, WhatThePosesDoNotShowIsNotKnown) {
  EXPECT_EQ(fit_mount({}).acc.lack, MountLack::kNoRest);
  const MountFit one = fit({kLevel}, {}, 1);
  EXPECT_EQ(one.acc.lack, MountLack::kOnePose);
  EXPECT_EQ(one.gyr.lack, MountLack::kNoTurn);
  EXPECT_EQ(fit({kLevel, exp_quat(Vec3(0, -0.4, 0)), kBottomUp}, {}, 1).acc.lack, MountLack::kOnePose) << "too alike";
  const MountFit axis = fit({kLevel, kFrontUp, kLevel, kFrontUp}, {}, 2);
  EXPECT_TRUE(axis.acc.known());
  EXPECT_EQ(axis.gyr.lack, MountLack::kOneAxis);
  EXPECT_EQ(axis.mag.lack, MountLack::kNoGyroscope);
}

/// Laid down as at first where another face was stated: that rest is taken for what it is.
TEST(Mount, ARestThatIsNotAsStatedIsRecognisedLikeAnyOther) {
  MountParams stated;
  stated.faces = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()};
  const MountFit found = fit({kLevel, kFrontUp, kLevel}, {}, 23, {}, stated);
  ASSERT_TRUE(found.acc.known());
  EXPECT_GT(found.acc.covariance.diagonal().minCoeff(), 0.0);
  EXPECT_LT(found.acc.covariance.diagonal().maxCoeff(), 0.01);
  EXPECT_FALSE(found.acc.poses[2].stated);
  EXPECT_EQ(*found.acc.poses[2].face, Vec3(Vec3::UnitZ()));
}

TEST(Mount, TurnsAboutTwoAxesLeaveAMirrorOpenAndThreeDoNot) {
  const MountFit two = fit({kLevel, kFrontUp, kLevel, kLeftUp, kLevel}, {}, 3);
  ASSERT_TRUE(two.gyr.known()) << name(two.gyr.lack);
  EXPECT_FALSE(two.gyr.mirror_excluded);
  EXPECT_TRUE(fit(kThreeSides, {}, 3).gyr.mirror_excluded);
}

TEST(Mount, ReadingsThatNoMapExplainsAreAContradiction) {
  std::vector<std::vector<RawSample>> recordings{placements(kManySides, {}, 9)};
  for (RawSample& s : recordings[0]) vec(s.gyr_radps) *= 2.0;
  EXPECT_EQ(fit_mount(mount_evidence(recordings)).gyr.lack, MountLack::kContradiction);
}

TEST(Mount, WindowsWithoutATurnBetweenThemAreOnePlacement) {
  std::vector<std::vector<RawSample>> recordings{
      placements({kLevel, kLevel, exp_quat(Vec3(0, 0, 0.05)), exp_quat(Vec3(0, 0, 1.0)), kFrontUp}, {}, 4)};
  const MountEvidence seen = mount_evidence(recordings);
  ASSERT_EQ(seen.rests.size(), 3U) << "a turn about the vertical is another placement, being pushed is none";
  EXPECT_EQ(seen.turns.size(), 2U);
  recordings[0].erase(recordings[0].end() - 450, recordings[0].end() - 350);
  EXPECT_EQ(mount_evidence(recordings).broken_turns, 1U) << "a second without readings on the way";
}

TEST(Mount, DerivativesAreThoseOfCentralDifferences) {
  constexpr double h = 1e-6;
  Preintegrated way;
  for (int k = 0; k < 200; ++k) way.advance(Vec3(0.4, 0.3 * std::sin(0.05 * k), -0.5), Mat3::Identity(), 0.01);
  const Mat3 G = exp_so3(Vec3(0.3, -1.0, 0.5));
  const AccWay at = in_acc_axes(way, G, Vec6::Zero());
  const Vec3 v(0.3, -0.7, 1.1);
  for (int k = 0; k < 6; ++k) {
    const Vec6 d = h * Vec6::Unit(k);
    const Vec3 turn = log_so3(in_acc_axes(way, G, -d).R.transpose() * in_acc_axes(way, G, d).R) / (2.0 * h);
    EXPECT_LT((turn - at.d_end_d_shape.col(k)).norm(), 1e-6) << k;
    EXPECT_TRUE(Vec3(symmetric(Vec6::Unit(k)) * v).isApprox(symmetric_times(v).col(k))) << k;
  }
}

}  // namespace
}  // namespace stillpoint::calib

/// Which field the heading refers to, and when another one takes its place.
#include "fusion/field_reference.h"

#include <gtest/gtest.h>

namespace stillpoint::fusion {
namespace {

constexpr double kStep_s = 0.5;
constexpr FieldReferenceParams kParams{.learn_time_s = 5.0, .accept_time_s = 10.0};

struct At {
  double horizontal_uT, vertical_uT;
};
constexpr At kHome{20.0, -45.0}, kRoom{30.0, -35.0}, kOther{10.0, -60.0};

/// The last verdict of so long in one field.
FieldVerdict stay(FieldReference& field, const At& at, double time_s, bool moving = true) {
  FieldVerdict out;
  for (double t = 0.0; t < time_s - 1e-9 && !out.accepted; t += kStep_s)
    out = field.observe(kParams, at.horizontal_uT, at.vertical_uT, kStep_s, moving);
  return out;
}

FieldReference at_home() {
  FieldReference field;
  stay(field, kHome, 20.0);
  return field;
}

TEST(FieldReference, AnotherFieldIsAcceptedAfterItsTimeOfMotion) {
  FieldReference field = at_home();
  EXPECT_TRUE(stay(field, kHome, 1.0).trusted);
  const FieldVerdict early = stay(field, kRoom, 9.0);
  EXPECT_FALSE(early.trusted || early.accepted);
  EXPECT_GT(early.heading_variance_rad2, 0.05);
  EXPECT_TRUE(stay(field, kRoom, 3.0).accepted);
  EXPECT_TRUE(stay(field, kRoom, 1.0).trusted);
  EXPECT_FALSE(stay(field, kHome, 1.0).trusted) << "the reference is where the body is now";
}

TEST(FieldReference, WhatLiesBesideAMagnetAcceptsNothing) {
  FieldReference field = at_home();
  EXPECT_FALSE(stay(field, kRoom, 60.0, false).accepted);
}

TEST(FieldReference, NeitherTimeInAThirdFieldNorFromBeforeGoingHomeCounts) {
  FieldReference through_two = at_home(), home_between = at_home(), lost_between = at_home();
  stay(through_two, kRoom, 8.0);
  EXPECT_FALSE(stay(through_two, kOther, 8.0).accepted);
  stay(home_between, kRoom, 8.0);
  stay(home_between, kHome, 1.0);
  EXPECT_FALSE(stay(home_between, kRoom, 8.0).accepted);
  stay(lost_between, kRoom, 8.0);
  stay(lost_between, {1.0, -40.0}, 1.0);  // no horizontal field, no heading
  EXPECT_FALSE(stay(lost_between, kRoom, 8.0).accepted);
}

}  // namespace
}  // namespace stillpoint::fusion

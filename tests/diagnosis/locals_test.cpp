/// Several windows are one cause that switches; what one cause leaves in its own window is none.
#include <gtest/gtest.h>

#include "diagnosis/reference/findings.h"

namespace stillpoint::diag {
namespace {

Found local(Eigen::Index begin, Eigen::Index end, double gain_nats) {
  Found f;
  f.kind = Kind::kUnknown;
  f.window = {true, begin, end};
  f.gain_nats = gain_nats;
  return f;
}

int locals_of(std::vector<Found> found) {
  SensorSearch search;
  search.found = std::move(found);
  return locals(search);
}

TEST(Locals, TwoWindowsAreTwoEventsHoweverUnequal) {
  EXPECT_EQ(locals_of({local(100, 300, 900), local(600, 700, 30)}), 2);
  EXPECT_EQ(locals_of({local(100, 300, 900), local(250, 500, 400)}), 2) << "of one size, although they overlap";
  EXPECT_EQ(locals_of({local(100, 300, 900), local(101, 299, 400)}), 1) << "came and went together";
}

TEST(Locals, WhatAStrongerOneLeavesInItsWindowIsNoSecondEvent) {
  EXPECT_EQ(locals_of({local(100, 300, 900), local(150, 220, 40)}), 1);
  EXPECT_EQ(locals_of({local(100, 300, 900), local(60, 120, 100)}), 1) << "at its edge";
}

TEST(Locals, BesideALastingCauseThatExplainsMoreAreDetails) {
  Found lasting = local(0, 1000, 500);
  lasting.window = {};
  EXPECT_EQ(locals_of({lasting, local(100, 300, 90), local(600, 700, 30)}), 0);
  EXPECT_EQ(locals_of({lasting, local(100, 300, 900)}), 1);
}

}  // namespace
}  // namespace stillpoint::diag
